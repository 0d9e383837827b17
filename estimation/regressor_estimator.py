"""The filtered-regressor estimator: recursive least squares, both sides through `rate / (s + rate)` (physics 11).

Motion is followed without wrenches and smoothed over the last moments (`motion_tracker.py`); several times a second a
block of it becomes a row (`filtered_row.py`), and rows add up (`regression_belief.py`). Force noise stands on one side
of a row only, and what is noise in the other is taken off, so that neither biases the mass.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement, Motion, ParameterEstimate

from .batch.physical_fit import PhysicalSet
from .gaussian import Gaussian, normalised_square
from .health import Health
from .load_change import load_covariance
from .noise import FilterNoise
from .parameter_report import ParameterReport
from .prior import Prior
from .regressor.filtered_row import Recorded, curvature_noise, filtered_row, stands_still
from .regressor.load_watch import LoadWatch
from .regressor.motion_tracker import Moment, MotionTracker, Stretch
from .regressor.regression_belief import RegressionBelief
from .wrench_sensing import WrenchSensing

BLOCK, LAG = 0.15, 0.12
"""s: how long a row is, and how much later it is worked out, when its end is smoothed."""
LONG_GAP = 0.3
"""s: across a longer one nothing is carried."""
JUMP = 14.0
"""Normalised square of a step of the wrench that is no noise."""
HELD = 0.1
"""s: how old a wrench may be."""


class RegressorEstimator:
    """Learns while the cart is pushed, as `CartFilter` does and with its arguments. Parameters change with each row,
    motion with each measurement."""

    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[str] | None = None,
        *,
        noise: FilterNoise | None = None,
        prior: Prior | None = None,
        yaws: Mapping[str, float] | None = None,
    ) -> None:
        self.cart, self.noise, self.prior = cart, noise or FilterNoise(), prior or Prior()
        self._free = self.prior.free(cart)
        self._first_covariance = self.prior.covariance(cart)[np.ix_(self._free, self._free)]
        first = Gaussian(cart.parameters[self._free], self._first_covariance)
        self._belief = RegressionBelief(self._free, first, cart.constraints.n_free)
        self._tracker = MotionTracker(cart, self.noise)
        self._sensing = WrenchSensing(cart, arms, yaws or {}, self.noise.wrench_covariance)
        self._watch = LoadWatch(cart.constraints.n_free)
        self._limits = PhysicalSet.of(cart, "regressor")
        self._reporter = ParameterReport(cart, self.prior)
        self._moments: list[Moment] = []
        self._recorded: list[Recorded | None] = []
        self._memory: Array | None = None
        self._jolt = np.zeros(cart.constraints.n_free)
        self._started = self._has_wrench = False
        self._conclude()

    def update(self, measurement: Measurement) -> Estimate:
        """Goes on to the measurement's time, takes in what it holds, and says what is known."""
        if not np.isfinite(measurement.time):
            raise UsageError(f"measurement: time {measurement.time} is not finite")
        self._sensing.note_contacts(measurement)
        pose = np.full(3, np.nan) if measurement.pose is None else np.asarray(measurement.pose, dtype=float)
        if self._moments and measurement.time < self._moments[-1].time - 1e-9:
            return replace(self.estimate, health=Health.CLOCK)
        if not self._started or measurement.time - self._moments[-1].time > LONG_GAP:
            self._start(measurement.time, pose)
        else:
            self._go_on(measurement.time)
            self._moments[-1] = self._tracker.with_pose(self._moments[-1], pose)
        if measurement.velocity is not None:
            velocity = np.asarray(measurement.velocity, dtype=float)
            self._moments[-1] = self._tracker.with_velocity(self._moments[-1], velocity)
        if measurement.wrenches:
            self._take_wrenches(measurement)
        self._take_row()
        return self.estimate

    @property
    def belief(self) -> Gaussian:
        """Mean and covariance of the free parameters, physical or not."""
        return self._belief.parameters

    @property
    def lateness(self) -> float:
        """Of the wrenches, beyond being held from sample to sample, in sample periods; mere samples have -0.5."""
        return self._belief.lateness

    @property
    def estimate(self) -> Estimate:
        if not self._moments:
            raise UsageError("regressor: no measurement has come yet")
        now = self._moments[-1]
        self._watch.go_on(now.time)
        motion = Motion(now.believed.mean[:3].copy(), now.believed.mean[self.cart.velocity_slice].copy())
        health = self._watch.health if self._has_wrench else Health.NO_WRENCH
        return Estimate(now.time, motion, self._report, health, self.cart, self._theta.copy(), self._covariance.copy())

    # --- moments ---------------------------------------------------------------------------------------------

    def _start(self, time: float, pose: Array) -> None:
        """Motion starts anew; the parameters stay."""
        self._moments, self._recorded = [self._tracker.first(time, pose)], [None]
        self._memory, self._jolt = None, np.zeros(self.cart.constraints.n_free)
        self._belief.unlink()
        self._started = bool(np.isfinite(pose[2]))  # without a heading nobody knows where anything pushes

    def _go_on(self, time: float) -> None:
        last = self._moments[-1]
        if time - last.time <= 1e-9:
            return
        self._moments.append(self._tracker.next(last, time, self._jolt))
        self._jolt = np.zeros(self.cart.constraints.n_free)
        held = self._recorded[-1]
        self._recorded.append(held if held is not None and time - held.time < HELD else None)

    def _take_wrenches(self, measurement: Measurement) -> None:
        sensed = self._sensing.sense(measurement, self._theta)
        if sensed is None:
            return
        before = self._recorded[-2] if len(self._recorded) > 1 else None
        if before is not None:
            self._jolt = self._jolt_of(sensed.value - before.sensed.value, sensed.covariance + before.sensed.covariance)
        self._recorded[-1] = Recorded(measurement.time, sensed, self._theta)
        self._has_wrench = True

    def _jolt_of(self, step: Array, noise: Array) -> Array:
        """The change of nu' that a step of the wrench makes, where it stands out of its noise."""
        if float(normalised_square(step, noise + 1e-10 * np.eye(len(step)))) < JUMP:
            return np.zeros(len(step))
        at_rest = self.cart.state()
        mass = self.cart.inverse(at_rest, np.zeros(len(step)), self._theta).by_acceleration
        return np.asarray(np.linalg.solve(mass, step))

    # --- rows ------------------------------------------------------------------------------------------------

    def _take_row(self) -> None:
        """Works out the block that has been over for long enough, if there is one."""
        time = np.array([moment.time for moment in self._moments])
        if time[-1] - time[0] < BLOCK + LAG - 1e-6:
            return
        k = int(np.searchsorted(time, time[0] + BLOCK - 1e-6))
        if time[-1] - time[k] < LAG - 1e-6:
            return
        motion = self._tracker.smoothed(self._moments).until(k)
        recorded = [one for one in self._recorded[:k] if one is not None]
        memory = self.cart.memory_along(motion.pose, motion.velocity, motion.time, self._theta, self._memory)
        if len(recorded) == k and not stands_still(motion):
            self._learn(motion, memory, recorded)
        else:
            self._belief.unlink()
        self._memory = memory[-1]
        self._moments, self._recorded = self._moments[k:], self._recorded[k:]

    def _learn(self, motion: Stretch, memory: Array, recorded: Sequence[Recorded]) -> None:
        row = filtered_row(self.cart, self._theta, motion, memory, recorded, self.noise)
        spread = np.zeros((len(self._theta), len(self._free)))
        spread[self._free] = np.linalg.cholesky(self.belief.covariance)
        curved = curvature_noise(self.cart, self._theta, motion, memory, spread)
        row = replace(row, noise=row.noise + curved)
        square = self._belief.absorb(row, self._theta)
        if self._watch.note(float(motion.time[-1]), square):
            opened = load_covariance(self.cart, self.prior, float(self._theta[0]))
            self._belief.open(opened[np.ix_(self._free, self._free)])
        self._conclude()

    def _conclude(self) -> None:
        """The parameters to linearise at and to report; where what is believed is no body, the most likely one is
        taken, and the belief stays as it is."""
        believed = self._belief.parameters
        theta = self.cart.parameters.copy()
        theta[self._free] = believed.mean
        if len(self._free):
            theta = self._limits.nearest(theta, self._free, believed.information)
        covariance = np.zeros((len(theta), len(theta)))
        covariance[np.ix_(self._free, self._free)] = believed.covariance
        share = np.ones(len(theta))
        share[self._free] = believed.std / np.sqrt(np.diagonal(self._first_covariance))
        self._theta, self._covariance = theta, covariance
        self._report: Mapping[str, ParameterEstimate] = self._reporter.of(theta, covariance, share)
