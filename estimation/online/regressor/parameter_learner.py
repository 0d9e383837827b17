"""The parameters, learned by recursive least squares with both sides through `rate / (s + rate)` (physics 11).

Motion is followed without wrenches and smoothed over the last moments (`motion_tracker.py`); several times a second a
block of it becomes a row (`filtered_row.py`), and rows add up (`regression_belief.py`). Force noise stands on one side
of a row only, and what is noise in the other is taken off, so that neither biases the mass. What surprises is a push,
a load or another floor (`trial.py`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import Self

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement, Motion, ParameterEstimate
from cartgrasp.shallow import shallow

from ...gaussian import Gaussian
from ...health import Health
from ...noise import FilterNoise
from ...parameter_report import ParameterReport, WhenAsked, as_taught
from ...physical_set import PhysicalSet
from ...prior import Prior
from ..disturbance.observer import USUAL_PUSH
from ..kernels.filtered_row import FilteredRow, weights
from ..kernels.recorded_moment import DUE, FELT
from ..load_change import load_covariance, root_of
from ..seen import NOTHING_FELT, NOTHING_SEEN, Seen
from ..wrench_sensing import Moving, WrenchSensing
from .filtered_row import Block, filtered_row, is_slower, left_out, stands_still
from .followed_memory import FollowedMemory
from .load_watch import ROWS, LoadWatch
from .mass_products import MassProducts
from .motion_tracker import MotionTracker
from .regression_belief import RegressionBelief
from .trial import Taken, Trial

LONG_GAP = 0.3
"""s: across a longer one nothing is carried."""


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
        pairs = np.ix_(self._free, self._free)
        self._root = root_of(load_covariance(cart, self.prior, 1.0))  # of a load's covariance, by mass
        self._products = MassProducts.of(cart, self._free)
        first = Gaussian(cart.parameters[self._free], self.prior.covariance(cart)[pairs])
        self._first_variances = np.diagonal(first.covariance)
        self._belief = RegressionBelief(self._free, first, cart.constraints.n_free, cart.parameters, self._products)
        self.tracker = MotionTracker(cart, self.noise)
        self._sensing = WrenchSensing(cart, arms, yaws, noise.wrench_covariance)
        self._left_out = left_out(cart, noise, self._products.scaled)
        self._watch = LoadWatch(cart.constraints.n_free, len(self._free))
        self._limits = PhysicalSet.of(cart, "regressor")
        self.reporter = ParameterReport(cart, self.prior)
        self._report: Mapping[str, ParameterEstimate] | None = None
        self._trial: Trial | None = None
        self.tried = self.loaded = -math.inf  # when a trial was over last, and when one ended with another load
        self._taken: tuple[Taken, ...] = ()  # the last rows
        self._push = np.diag(USUAL_PUSH * noise.wrench_scale(cart)) ** 2
        self._memory = FollowedMemory(cart, noise.swivel)
        self.believed, self._at_rest = np.zeros(0), (cart.state(), np.zeros(cart.constraints.n_free))
        self.theta = cart.parameters
        self._seen, self._started, self._has_wrench = Seen(), False, False
        self.worked = False  # whether the last sample brought a row, which takes long
        self.time, self.seen, self.felt = -math.inf, NOTHING_SEEN, NOTHING_FELT  # of the last measurement
        self._seen_until = -math.inf  # time of the last pose or velocity
        self._conclude()

    def take(self, measurement: Measurement) -> None:
        """Goes on to the measurement's time, which is no earlier than the last one's, and takes in what it holds."""
        time, sensing = float(measurement.time), self._sensing
        sensing.note_contacts(measurement)
        seen = self.seen = self._seen.of(measurement)
        is_seen = self._seen.is_whole or bool(np.isfinite(seen).any())
        if not self._started or time - (self._seen_until if is_seen else self.time) > LONG_GAP:
            self._start(time)
            seen = np.concatenate([NOTHING_SEEN[:3], seen[3:]])
        if is_seen:
            self._seen_until = time
        moving = self._moving(time) if sensing.feels_motion else None
        grip = sensing.gripped(measurement.wrenches, self.theta, moving)
        if sensing.corrects:
            self._believe()
        said = self.tracker.record(time, seen, grip.wrenches, grip.matrix, self.believed)
        self.time = self.tracker.last_time
        self.worked = said & DUE > 0
        if self.worked:
            self._take_row()
        self._watch.go_on(time)
        if said & FELT:
            self.felt, self._has_wrench = self.tracker.felt, True
        else:
            self.felt = NOTHING_FELT

    def hear(self, loudness: Array) -> None:
        """Variances of velocities, linear and yaw (2,), are so many times the declared ones."""
        self.tracker.hear(np.diag(self.noise.velocity_covariance) * loudness[[0, 0, 1]])

    def _moving(self, time: float) -> Moving:
        """The cart as it was seen last, with memories as they were at the beginning of the block."""
        motion = self.motion
        return Moving(np.concatenate([motion.pose_sb, motion.velocity, self._memory.mean]), time)

    @property
    def motion(self) -> Motion:
        """The motion as poses and velocities alone tell it."""
        now = self.tracker.now.mean
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
        other.tracker, other._belief = self.tracker.copy(), self._belief.copy()
        other._watch, other._sensing = shallow(self._watch), self._sensing.copy()
        return other

    @property
    def belief(self) -> Gaussian:
        """Mean and covariance of the free parameters, physical or not."""
        return self._belief.parameters

    @property
    def lateness(self) -> float:
        """Lateness of the wrenches in sample periods, beyond being held from sample to sample; mere samples have
        -0.5."""
        return self._belief.lateness

    # --- moments ---------------------------------------------------------------------------------------------

    def _start(self, time: float) -> None:
        """Motion starts anew; the parameters stay."""
        pose = self.seen[:3]
        self.tracker.start(time, pose)
        self._memory = self._memory.lost()
        self._unlink()
        self._started = math.isfinite(pose[2])  # without a heading nobody knows where anything pushes

    def _believe(self) -> None:
        """Sets what is believed for the next wrenches."""
        self.believed = np.concatenate([part.ravel() for part in (self._sensing.by_parameters, self.theta, self._mass)])

    # --- rows ------------------------------------------------------------------------------------------------

    def _take_row(self) -> None:
        """Works out the block that has been over for long enough, if there is one and motion was seen after it."""
        k, end = self.tracker.over()
        if not k:
            return
        if self.tracker.time[end - 1] <= self._seen_until:
            self._take_block(k, end)
        elif self.time - self._seen_until > LONG_GAP:
            self._unlink()
            self._memory = self._memory.lost()
            self.tracker.drop(k)

    def followed(self, moments: int, before: float) -> int:
        """Kernels went on to so many moments with wrenches, of which the last but one was at a time; with them a row
        was due. Returns how many moments are left."""
        self.tracker.followed(moments)
        self.time, self._has_wrench = self.tracker.last_time, True
        self._seen_until = max(self._seen_until, self.tracker.seen_until)
        self._watch.go_on(before)
        self._take_row()
        return len(self.tracker.time)

    def _take_block(self, k: int, end: int) -> None:
        """The first `end` moments, of which k are dropped."""
        tracker = self.tracker
        weighing = weights(tracker.time[:end], end - k)
        moved, wrenches = tracker.smoothed(weighing.of_motion), tracker.wrenches(end - 1)
        moved = self._memory.along(moved, self.theta)
        is_slow = self._least_speed > 0 and is_slower(moved, self.cart, self._least_speed)
        is_whole = np.isfinite(wrenches[:, 0]).all() and not tracker.is_torn(end - 1)
        is_still = stands_still(moved, self.cart)
        if is_whole and not is_slow and not is_still:
            self._learn(Block(weighing, moved, wrenches))
        else:
            self._unlink(is_still=bool(is_whole and is_still))
        self._memory = self._memory.after(moved, k)
        tracker.drop(k)

    def _unlink(self, *, is_still: bool = False) -> None:
        """The next block does not begin where the last one ended, or stood still."""
        self._belief.unlink()
        self._taken = ()
        if self._trial is not None:
            self._settle(self._trial.unlinked(is_still=is_still), self.time)
            self._conclude()

    def _learn(self, block: Block) -> None:
        known = Gaussian(self.theta, self.covariance)
        row = filtered_row(self.cart, known, self._spread, block, self._left_out)
        time = float(block.moved.time[-1])
        if self._trial is None:
            self._take_in(row, time)
        else:
            trial = self._trial.and_then(row, self.theta)
            self._watch.follow(time, trial.surprise, is_pushed=trial.is_pushed)
            self._settle(trial, time)
        self._conclude()

    def _take_in(self, row: FilteredRow, time: float) -> None:
        before = self._belief.copy()
        root = (self._products.by_factors(self.theta) @ (float(self.theta[0]) * self._root))[self._free]
        surprise = self._belief.absorb(row, self.theta)
        self._taken = (*self._taken, Taken(before, row, self.theta))[-ROWS:]
        if self._watch.note(time, surprise, root):
            floor = self._products.floor(self.theta)[np.ix_(self._free, self._free)]
            self._settle(Trial.since(self._taken, root @ root.T, floor, self._push), time)
            self._taken = ()

    def _settle(self, trial: Trial, time: float) -> None:
        """What is believed while a push and a load both are, and whether that is decided."""
        self._trial, self._belief = None if trial.is_over else trial, trial.belief
        if trial.is_over:
            self.tried, self.loaded = time, time if trial.is_loaded else self.loaded
        self._watch.settle(time, trial)

    def _conclude(self) -> None:
        """The parameters to linearise at and to report; where what is believed is no body, the most likely one is
        taken, and the belief stays as it is."""
        theta, self.covariance, self._spread = self._belief.concluded()
        if len(self._free) and not self._limits.holds(theta):
            with suppress(DataError):  # where what is believed is beyond numbers, what was stays
                self.theta = self._limits.nearest(theta, self._free, self._belief.parameters.information)
            theta = self.theta
        self.theta, self._report = theta, None
        self._mass = self.cart.inverse(*self._at_rest, theta).by_acceleration
        self._believe()

    @property
    def report(self) -> Mapping[str, ParameterEstimate]:
        """What is said of the parameters."""
        if self._report is None:
            given = self.theta, self.covariance, self._free, self._first_variances
            self._report = WhenAsked(partial(self.reporter.of_free, *given))
        return as_taught(self._report, self._watch.health)
