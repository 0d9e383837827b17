"""The parameters, learned by recursive least squares with both sides through `rate / (s + rate)` (physics 11).

Motion is followed without wrenches and smoothed over the last moments (`motion_tracker.py`); several times a second a
block of it becomes a row (`filtered_row.py`), and rows add up (`regression_belief.py`), what the first could not say at
once a little later (`second_look.py`). Force noise stands on one side of a row only, and what is noise in the other is
taken off, so that neither biases the mass.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Self

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement, Motion, ParameterEstimate

from ..batch.physical_fit import PhysicalSet
from ..gaussian import Gaussian
from ..health import Health
from ..kernels.correction import normalised_square
from ..load_change import load_covariance
from ..noise import FilterNoise
from ..parameter_report import ParameterReport
from ..prior import Prior
from ..seen import NOTHING_SEEN, seen_in
from ..shallow import shallow
from ..wrench_sensing import SensedWrench, WrenchSensing
from .filtered_row import Block, FilteredRow, Recorded, Weights, curvature_noise, filtered_row, is_slower, stands_still
from .load_watch import LoadWatch
from .motion_tracker import MotionTracker
from .regression_belief import RegressionBelief
from .second_look import AT_ONCE, BLURRED, MOST_WAITING, SecondLook, blur

BLOCK, WIDTH, LAG = 0.1, 0.1, 0.12
"""s: how long a block is, over how long its ends are means, and how much later its row is worked out, when they are
smoothed."""
LONG_GAP = 0.3
"""s: across a longer one nothing is carried."""
JUMP = 14.0
"""Normalised square of a step of the wrench that is no noise."""
HELD = 0.1
"""s: how old a wrench may be."""
MOST_JOLT = 100.0
"""m/s² or rad/s²."""


class ParameterLearner:
    """Changes what it believes of the parameters with each row, of the motion with each measurement."""

    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[str] | None,
        noise: FilterNoise,
        prior: Prior,
        yaws: Mapping[str, float],
        least_speed: float = 0.0,
    ) -> None:
        self.cart, self.noise, self.prior, self._least_speed = cart, noise, prior, least_speed
        self._free = self.prior.free(cart)
        self._first_covariance = self.prior.covariance(cart)[np.ix_(self._free, self._free)]
        first = Gaussian(cart.parameters[self._free], self._first_covariance)
        self._belief = RegressionBelief(self._free, first, cart.constraints.n_free)
        self._tracker = MotionTracker(cart, self.noise)
        self._sensing = WrenchSensing(cart, arms, yaws, noise.wrench_covariance)
        self._watch = LoadWatch(cart.constraints.n_free, len(self._free))
        self._limits = PhysicalSet.of(cart, "regressor")
        self._reporter = ParameterReport(cart, self.prior)
        self._recorded: list[Recorded | None] = []
        self._again: SecondLook | None = None
        self._memory: Array | None = None
        self._calm = self._jolt = np.zeros(cart.constraints.n_free)
        self._room = np.empty(12)
        self._started = self._has_wrench = False
        self.time, self.seen = -math.inf, NOTHING_SEEN  # of the last measurement
        self.sensed: SensedWrench | None = None  # of the last measurement with wrenches
        self._conclude()

    def take(self, measurement: Measurement) -> None:
        """Goes on to the measurement's time, which is no earlier than the last one's, and takes in what it holds."""
        time = float(measurement.time)
        self._sensing.note_contacts(measurement)
        self.seen = seen_in(measurement)
        gap = time - self.time
        if not self._started or gap > LONG_GAP:
            self._start(time)
        else:
            self._go_on(time, gap)
        self.time = self._tracker.last_time
        if measurement.wrenches:
            self._take_wrenches(measurement)
        self._take_row()
        self._watch.go_on(time)

    @property
    def motion(self) -> Motion:
        """As poses and velocities alone tell it."""
        now = self._tracker.now.mean
        return Motion(now[:3], now[self.cart.velocity_slice])

    @property
    def health(self) -> Health:
        return self._watch.health if self._has_wrench else Health.NO_WRENCH

    @property
    def surprise(self) -> float:
        """The last row's normalised square over the gate beyond which it counts less."""
        return self._watch.ratio

    def estimate(self, motion: Motion, health: Health) -> Estimate:
        """What is known by now, with a motion."""
        return Estimate(self.time, motion, self.report, health, self.cart, self.theta, self.covariance)

    def copy(self) -> Self:
        other = shallow(self)
        other._tracker, other._belief = self._tracker.copy(), self._belief.copy()
        if self._again is not None:
            other._again = replace(self._again, belief=self._again.belief.copy())
        other._watch, other._sensing = shallow(self._watch), self._sensing.copy()
        other._recorded = list(self._recorded)
        return other

    @property
    def belief(self) -> Gaussian:
        """Mean and covariance of the free parameters, physical or not."""
        return self._belief.parameters

    @property
    def lateness(self) -> float:
        """Of the wrenches, beyond being held from sample to sample, in sample periods; mere samples have -0.5."""
        return self._belief.lateness

    # --- moments ---------------------------------------------------------------------------------------------

    def _start(self, time: float) -> None:
        """Motion starts anew; the parameters stay."""
        pose = self.seen[:3]
        self._tracker.start(time, pose)
        self._tracker.take(np.concatenate([NOTHING_SEEN[:3], self.seen[3:]]))
        self._recorded = [None]
        self._memory, self._jolt = None, self._calm
        self._unlink()
        self._started = math.isfinite(pose[2])  # without a heading nobody knows where anything pushes

    def _go_on(self, time: float, gap: float) -> None:
        if gap <= 1e-9:
            self._tracker.take(self.seen)
            return
        self._tracker.next(time, self._jolt, self.seen)
        self._jolt = self._calm
        held = self._recorded[-1]
        self._recorded.append(held if held is not None and time - held.time < HELD else None)

    def _take_wrenches(self, measurement: Measurement) -> None:
        sensed = self.sensed = self._sensing.sense(measurement, self.theta)
        if sensed is None:
            return
        before = self._recorded[-2] if len(self._recorded) > 1 else None
        if before is not None:
            self._jolt = self._jolt_of(sensed.value - before.sensed.value, sensed.covariance + before.sensed.covariance)
        self._recorded[-1] = Recorded(measurement.time, sensed, self.theta)
        self._has_wrench = True

    def _jolt_of(self, step: Array, noise: Array) -> Array:
        """The change of nu' that a step of the wrench makes, where it stands out of its noise."""
        if normalised_square(step, noise, self._room) < JUMP:
            return self._calm
        at_rest = self.cart.state()
        mass = self.cart.inverse(at_rest, np.zeros(len(step)), self.theta).by_acceleration
        return np.asarray(np.clip(np.linalg.solve(mass, step), -MOST_JOLT, MOST_JOLT))

    # --- rows ------------------------------------------------------------------------------------------------

    def _take_row(self) -> None:
        """Works out the block that has been over for long enough, if there is one."""
        if self._tracker.last_time - self._tracker.first_time < BLOCK + LAG - 1e-6:
            return
        time = self._tracker.time
        k, end = np.searchsorted(time, time[0] + BLOCK + np.array([0.0, WIDTH]) - 1e-6).tolist()
        if time[-1] - time[min(end, len(time)) - 1] < LAG - 1e-6:
            return
        weights = Weights.of(time[:end], end - k)
        motion = self._tracker.smoothed(weights.of_motion)
        recorded = [one for one in self._recorded[: end - 1] if one is not None]
        memory = self.cart.memory_along(motion.pose, motion.velocity, motion.time, self.theta, self._memory)
        moves = not stands_still(motion) and not is_slower(motion, self.cart, self._least_speed)
        if len(recorded) == end - 1 and moves and not self._tracker.is_torn(end - 1):
            self._learn(Block(weights, motion, memory, recorded))
        else:
            self._unlink()
        self._memory = memory[k]
        self._tracker.drop(k)
        self._recorded = self._recorded[k:]

    def _unlink(self) -> None:
        """The next block does not begin where the last one ended."""
        self._belief.unlink()
        if self._again is not None:
            self._again = self._again.and_then(None)

    def _learn(self, block: Block) -> None:
        row, curvature = self._worked_out(block)
        if self._again is None and blur(row, curvature) > BLURRED:
            self._again = SecondLook(self._belief.copy())
        if self._again is not None:
            self._again = self._again.and_then(block)
        surprise = self._belief.absorb(replace(row, noise=row.noise + curvature), self.theta)
        load = load_covariance(self.cart, self.prior, float(self.theta[0]))[np.ix_(self._free, self._free)]
        if self._watch.note(float(block.motion.time[-1]), surprise, load):
            self._belief.open(load)
            self._again = None
        self._conclude()
        self._look_again()

    def _worked_out(self, block: Block) -> tuple[FilteredRow, Array]:
        """The row around what is believed now, and the covariance of what it leaves out."""
        row = filtered_row(self.cart, Gaussian(self.theta, self.covariance), block, self.noise)
        spread = np.zeros((len(self.theta), len(self._free)))
        spread[self._free] = np.linalg.cholesky(self.belief.covariance)
        return row, curvature_noise(self.cart, self.theta, block, spread)

    def _look_again(self) -> None:
        """At the next blocks, once the first of them is no longer blurred."""
        again = self._again
        if again is None:
            return
        if not again.due:
            first = again.left[0]
            due = first is None or len(again.left) >= MOST_WAITING or blur(*self._worked_out(first)) <= BLURRED
            again = replace(again, due=due)
        if again.due:
            for block in again.left[:AT_ONCE]:
                self._take_again(again.belief, block)
            again = replace(again, left=again.left[AT_ONCE:])
        self._again = again
        if again.is_over:
            self._belief, self._again = again.belief, None
            self._conclude()

    def _take_again(self, belief: RegressionBelief, block: Block | None) -> None:
        if block is None:
            belief.unlink()
            return
        row, curvature = self._worked_out(block)
        belief.absorb(replace(row, noise=row.noise + curvature), self.theta)

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
        self.theta, self.covariance = theta, covariance
        self.report: Mapping[str, ParameterEstimate] = self._reporter.of(theta, covariance, share)
