"""The parameters, learned by recursive least squares with both sides through `rate / (s + rate)` (physics.md).

Motion is followed without wrenches and smoothed over the last moments (`motion_tracker.py`); several times a second a
block of it becomes a row (`filtered_row.py`), and `row_learning.py` believes what rows teach. Force noise stands on one
side of a row only, and what is noise in the other is taken off, so that neither biases the mass.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Self

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement, Motion
from cartgrasp.shallow_copy import shallow_copy

from ...gaussian import Gaussian
from ...health import Health
from ...noise import FilterNoise
from ...prior import Prior
from ..kernels.recorded_moment import ROW_DUE, WRENCH_USED
from ..kernels.row_algebra import weights
from ..kernels.sensor_health import SENSOR_TIMEOUT
from ..measured_motion import NO_MOTION, NO_WRENCHES, MeasuredMotion
from ..wrench_sensing import Moving, WrenchSensing
from .filtered_row import AskedRow, Block, is_slower, stands_still
from .followed_memory import FollowedMemory
from .load_hypotheses import HypothesesOpening
from .motion_tracker import MotionTracker
from .row_learning import RowLearning
from .row_stages import DoneStage, HypothesesStage, RowStage, SmoothingStage, Stage, TakenInStage, UndecidedStage
from .wrench_noise_scale import WrenchNoiseScale

MAX_REGRESSION_GAP = 0.3
"""s: across a longer one nothing is carried."""
MIN_UNSLICED_INTERVAL = 0.004
"""s between samples: a loop that is faster has a row worked out in slices, one with each sample (`row_stages.py`)."""
SLICE_MOMENTS = 32
"""Moments that are smoothed in one."""


# Many methods: one sample's way from moment to block to row in slices, so that no tick bears a whole row.
class ParameterLearner:
    """Changes what is `learned` of the parameters with each row, what it believes of the motion with each
    measurement."""

    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[str] | None,
        noise: FilterNoise,
        prior: Prior,
        yaws: Mapping[str, float],
        least_speed: float = 0.0,
        unseen: float = 0.0,
    ) -> None:
        self.cart, self.noise, self._least_speed = cart, noise, least_speed
        self.learned = RowLearning(cart, noise, prior, unseen)
        self.tracker = MotionTracker(cart, noise)
        self._sensing = WrenchSensing(cart, arms, yaws, noise.wrench_covariance)
        self._memory = FollowedMemory(cart, noise.swivel)
        self._measured_motion, self._started = MeasuredMotion(), False
        self._is_elsewhere = False  # whether the motion begins anew with the next pose
        self.is_torn = False
        """Whether most samples of the last block missed their gates."""
        self.unfinished: Stage | None = None  # how far a row is worked out
        self.took_long = False  # whether something of a row was worked out with the last sample
        self.time, self.seen, self.measured_wrench = -math.inf, NO_MOTION, NO_WRENCHES  # of the last measurement
        self._motion_seen_at = -math.inf  # time of the last pose or velocity
        self._wrench_used_at = -math.inf  # and of the last wrench
        self._believe()

    def take(self, measurement: Measurement) -> None:
        """Goes on to the measurement's time, which is no earlier than the last one's, and takes in what it holds."""
        time, sensing = float(measurement.time), self._sensing
        sensing.note_contacts(measurement)
        seen = self.seen = self._measured_motion.of(measurement)
        is_seen = self._measured_motion.is_whole or bool(np.isfinite(seen).any())
        is_lost = not self._started or (self._is_elsewhere and bool(np.isfinite(seen[:3]).all()))
        if is_lost or time - (self._motion_seen_at if is_seen else self.time) > MAX_REGRESSION_GAP:
            self._start(time)
            seen = np.concatenate([NO_MOTION[:3], seen[3:]])
        if is_seen:
            self._motion_seen_at = time
        grip = sensing.gripped(measurement, self.learned.theta, self._moving(time) if sensing.feels_motion else None)
        if sensing.corrects:
            self._believe()
        said = self.tracker.record(time, seen, grip.wrenches, grip.matrix, self.believed)
        before, self.time = self.time, self.tracker.last_time
        is_due = said & ROW_DUE > 0
        # One slice an instant, but where a row is due.
        self.took_long = is_due or (self.unfinished is not None and self.time > before)
        if self.took_long:
            self._work(self.time - before, is_due=is_due)
        self.learned.note_time(time)
        if said & WRENCH_USED:
            self.measured_wrench, self._wrench_used_at = self.tracker.measured_wrench, self.time
        else:
            self.measured_wrench = NO_WRENCHES

    def note_disturbance(self, acts: bool) -> None:
        """Whether something else pushes in the rows that come next."""
        self.learned.is_disturbed = acts

    def begin_anew(self) -> None:
        """Poses that are elsewhere than believed are to be followed: motion starts anew with the next one."""
        self._is_elsewhere = True

    def note_push(self) -> None:
        """Somebody who has heard more found that what surprised is no load."""
        self._finish()
        self.learned.note_push(self.time)
        self._believe()

    def note_load_change(self, since: float) -> None:
        """Somebody else found another load, no earlier than some s."""
        self._finish()
        self.learned.note_load_change(self.time, since)
        self._believe()

    def scale_noise(self, noise_factors: Array) -> None:
        """Variances of velocities, linear and yaw (2,), are so many times the declared ones."""
        self.tracker.scale_noise(np.diag(self.noise.velocity_covariance) * noise_factors[[0, 0, 1]])

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
    def wrench_noise_scale(self) -> WrenchNoiseScale:
        return self.learned.wrench_noise_scale

    @property
    def health(self) -> Health:
        if not self._started or self.time - self._motion_seen_at > SENSOR_TIMEOUT:
            return Health.STALE
        is_felt = self.time - self._wrench_used_at <= SENSOR_TIMEOUT
        return self.learned.health if is_felt else Health.NO_WRENCH

    def estimate(self, motion: Motion, health: Health) -> Estimate:
        """What is known by now, with a motion."""
        learned = self.learned
        return Estimate(
            self.time, motion, learned.report, health, self.cart, learned.theta, learned.reported_covariance
        )

    def copy(self) -> Self:
        other = shallow_copy(self)
        other.tracker, other.learned, other._sensing = self.tracker.copy(), self.learned.copy(), self._sensing.copy()
        return other

    @property
    def belief(self) -> Gaussian:
        """Mean and covariance of the free parameters, physical or not."""
        return self.learned.belief

    # --- moments ---------------------------------------------------------------------------------------------

    def _start(self, time: float) -> None:
        """Motion starts anew; the parameters stay."""
        self._finish()
        pose = self.seen[:3]
        self.tracker.start(time, pose)
        self._memory = self._memory.lost()
        self._drop_link()
        self._is_elsewhere = self.is_torn = False
        self._started = math.isfinite(pose[2])  # without a heading nobody knows where anything pushes

    def _believe(self) -> None:
        """Sets what is believed for the next wrenches."""
        known = self._sensing.by_parameters, self.learned.theta, self.learned.mass_matrix
        self.believed = np.concatenate([part.ravel() for part in known])

    # --- rows ------------------------------------------------------------------------------------------------

    def _work(self, since: float, *, is_due: bool) -> None:
        """Goes on with a row, `since` (s) the last sample: in slices, where that is short."""
        if is_due and not isinstance(self.unfinished, SmoothingStage):
            self._finish()
            self._take_row()
        else:
            self._go_on()
        if not since < MIN_UNSLICED_INTERVAL:
            self._finish()

    def _go_on(self) -> None:
        """The next slice of a row, if one is left."""
        stage, self.unfinished = self.unfinished, None
        match stage:
            case SmoothingStage() if stage.smoothing.left:
                self.unfinished = stage._replace(smoothing=self.tracker.smoothed_on(stage.smoothing, SLICE_MOMENTS))
            case SmoothingStage():
                self.unfinished = self._block_of(stage)
            case Block():
                self.unfinished = self.learned.row_of(stage)
            case AskedRow():
                self.unfinished = self.learned.worked_on(stage)
            case RowStage():
                self.unfinished = self.learned.take_in(*stage)
            case HypothesesStage():
                self.unfinished = stage.go_on()
            case TakenInStage():
                self.unfinished = self.learned.with_noise_scale(stage)
            case UndecidedStage():
                self.unfinished = self.learned.decide(*stage)
            case HypothesesOpening():
                self.unfinished = self.learned.settle_opening(stage.go_on())
            case DoneStage():
                self.learned.conclude()
                self._believe()

    def _finish(self) -> None:
        while self.unfinished is not None:
            self._go_on()

    def _take_row(self) -> None:
        """Works out the block that has been over for long enough, if there is one and motion was seen after it."""
        k, end = self.tracker.over()
        if self.tracker.time[end - 1] <= self._motion_seen_at:
            weighing = weights(self.tracker.time[:end], end - k)
            self.unfinished = SmoothingStage(k, end, weighing, self.tracker.smoothing(weighing.of_motion[:2]))
            self._go_on()
        elif self.time - self._motion_seen_at > MAX_REGRESSION_GAP:
            self._drop_link()
            self._memory = self._memory.lost()
            self.tracker.drop(k)

    def note_moments(self, moments: int, before: float) -> int:
        """Kernels went on to so many moments with wrenches, of which the last but one was at a time; with them a row
        was due. Returns how many moments are left."""
        self.tracker.note_moments(moments)
        self.time = self._wrench_used_at = self.tracker.last_time
        self._motion_seen_at = max(self._motion_seen_at, self.tracker.seen_until)
        self.learned.note_time(before)
        self._work(self.time - before, is_due=self.tracker.over()[0] > 0)
        return len(self.tracker.time)

    def _block_of(self, begun: SmoothingStage) -> Block | None:
        """A block that teaches something; none where the cart stood still, or nobody knows how it moved."""
        k, end, weighing, smoothing = begun
        tracker = self.tracker
        moved = self._memory.along(smoothing.smoothed, self.learned.theta)
        wrenches, ahead = tracker.wrenches(end - 1, self.learned.wrench_delay)
        is_slow = self._least_speed > 0 and is_slower(moved, self.cart, self._least_speed)
        self.is_torn = tracker.is_torn(end - 1)
        is_whole = math.isfinite(ahead) and not self.is_torn
        is_still = stands_still(moved, self.cart)
        self._memory = self._memory.after(moved, k)
        tracker.drop(k)
        if is_whole and not is_slow and not is_still:
            return Block(weighing, moved, wrenches, ahead)
        self._drop_link(is_still=bool(is_whole and is_still))
        return None

    def _drop_link(self, *, is_still: bool = False) -> None:
        """The next block does not begin where the last one ended, or stood still."""
        self.learned.drop_link(self.time, is_still=is_still)
        self._believe()
