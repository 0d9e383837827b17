"""The parameters, learned by recursive least squares with both sides through `rate / (s + rate)` (physics.md).

Motion is followed without wrenches and smoothed over the last moments (`motion_tracker.py`); several times a second a
block of it becomes a row (`filtered_row.py`), and rows add up (`regression_belief.py`). Force noise stands on one side
of a row only, and what is noise in the other is taken off, so that neither biases the mass. What surprises is a push,
a load or another floor (`load_hypotheses.py`).
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
from cartgrasp.shallow_copy import shallow_copy

from ...gaussian import Gaussian
from ...health import Health
from ...noise import FilterNoise
from ...parameter_report import LazyParameters, ParameterReport, qualified_by_health
from ...physical_set import PhysicalSet
from ...prior import Prior
from ..disturbance.observer import PUSH_FORCE_STD
from ..kernels.recorded_moment import ROW_DUE, WRENCH_USED
from ..kernels.row_algebra import FilteredRow, UnmodelledNoise, weights
from ..kernels.sensor_health import SENSOR_TIMEOUT
from ..load_change import load_covariance, root_of
from ..measured_motion import NO_MOTION, NO_WRENCHES, MeasuredMotion
from ..wrench_sensing import Moving, WrenchSensing
from .disturbance_level import DisturbanceLevel
from .filtered_row import Block, filtered_row, is_slower, one_disturbance, stands_still
from .followed_memory import FollowedMemory
from .load_hypotheses import HypothesesStart, LearnedRow, LoadHypotheses
from .load_monitor import CHI2_TEST_ROWS, LoadMonitor
from .mass_products import MassProducts
from .motion_tracker import MotionTracker
from .regression_belief import Innovation, RegressionBelief
from .row_stages import DoneStage, HypothesisStage, NoiseScaleStage, RowStage, SmoothingStage, Stage, UpdateStage
from .scale import ScaleInformation
from .wrench_noise_scale import WrenchNoiseScale

MAX_REGRESSION_GAP = 0.3
"""s: across a longer one nothing is carried."""
MIN_UNSLICED_INTERVAL = 0.004
"""s between samples: a loop that is faster has a row worked out in slices, one with each sample (`row_stages.py`)."""
SLICE_MOMENTS = 32
"""Moments that are smoothed in one."""


# Many methods: one sample's way from block to row to belief in slices, so that no tick bears a whole row; each slice
# is a method, and they change one state.
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
        unseen: float = 0.0,
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
        self._one_disturbance = one_disturbance(cart, noise)
        self._level, self._is_disturbed = DisturbanceLevel.between(noise.disturbance, unseen), False
        self.wrench_noise_scale = WrenchNoiseScale()
        self._unscaled_rows: tuple[RowStage, ...] = ()  # rows that wait until the scale is known
        self._scale = ScaleInformation.of(cart, prior, self._free)
        self._load_monitor = LoadMonitor(cart.constraints.n_free, len(self._free))
        self._limits = PhysicalSet.of(cart, "regressor")
        self.reporter = ParameterReport(cart, self.prior)
        self._report: Mapping[str, ParameterEstimate] | None = None
        self.hypotheses: LoadHypotheses | None = None  # what surprised may be, while that is open
        self.last_decision = self.last_load_change = -math.inf  # s: of hypotheses, and of some for another load
        self._taken: tuple[LearnedRow, ...] = ()  # the last rows
        self._push = np.diag(PUSH_FORCE_STD * noise.wrench_scale(cart)) ** 2
        self._memory = FollowedMemory(cart, noise.swivel)
        self.believed, self._at_rest = np.zeros(0), (cart.state(), np.zeros(cart.constraints.n_free))
        self.theta = cart.parameters
        self._seen, self._started = MeasuredMotion(), False
        self.unfinished: Stage | None = None  # how far a row is worked out
        self.worked = False  # whether something of a row was worked out with the last sample, which takes long
        self.time, self.seen, self.measured_wrench = -math.inf, NO_MOTION, NO_WRENCHES  # of the last measurement
        self._seen_until = self._wrench_until = -math.inf  # times of the last pose or velocity, and of the last wrench
        self._conclude()

    def take(self, measurement: Measurement) -> None:
        """Goes on to the measurement's time, which is no earlier than the last one's, and takes in what it holds."""
        time, sensing = float(measurement.time), self._sensing
        sensing.note_contacts(measurement)
        seen = self.seen = self._seen.of(measurement)
        is_seen = self._seen.is_whole or bool(np.isfinite(seen).any())
        if not self._started or time - (self._seen_until if is_seen else self.time) > MAX_REGRESSION_GAP:
            self._start(time)
            seen = np.concatenate([NO_MOTION[:3], seen[3:]])
        if is_seen:
            self._seen_until = time
        grip = sensing.gripped(measurement, self.theta, self._moving(time) if sensing.feels_motion else None)
        if sensing.corrects:
            self._believe()
        said = self.tracker.record(time, seen, grip.wrenches, grip.matrix, self.believed)
        before, self.time = self.time, self.tracker.last_time
        is_due = said & ROW_DUE > 0
        self.worked = is_due or (self.unfinished is not None and self.time > before)  # one slice an instant
        if self.worked:
            self._work(self.time - before, is_due=is_due)
        self._load_monitor.go_on(time)
        if said & WRENCH_USED:
            self.measured_wrench, self._wrench_until = self.tracker.measured_wrench, self.time
        else:
            self.measured_wrench = NO_WRENCHES

    def note_disturbance(self, acts: bool) -> None:
        """Whether something else pushes in the rows that come next."""
        self._is_disturbed = acts

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
    def health(self) -> Health:
        if not self._started or self.time - self._seen_until > SENSOR_TIMEOUT:
            return Health.STALE
        is_felt = self.time - self._wrench_until <= SENSOR_TIMEOUT
        return self._load_monitor.health if is_felt else Health.NO_WRENCH

    @property
    def gate_ratio(self) -> float:
        """The last row's normalised square over the gate beyond which it counts less."""
        return self._load_monitor.ratio

    def estimate(self, motion: Motion, health: Health) -> Estimate:
        """What is known by now, with a motion."""
        return Estimate(self.time, motion, self.report, health, self.cart, self.theta, self.reported_covariance)

    def copy(self) -> Self:
        other = shallow_copy(self)
        other.tracker, other._belief = self.tracker.copy(), self._belief.copy()
        other._load_monitor, other._sensing = shallow_copy(self._load_monitor), self._sensing.copy()
        return other

    @property
    def belief(self) -> Gaussian:
        """Mean and covariance of the free parameters, physical or not."""
        return self._belief.parameters

    # --- moments ---------------------------------------------------------------------------------------------

    def _start(self, time: float) -> None:
        """Motion starts anew; the parameters stay."""
        self._finish()
        pose = self.seen[:3]
        self.tracker.start(time, pose)
        self._memory = self._memory.lost()
        self._drop_link()
        self._started = math.isfinite(pose[2])  # without a heading nobody knows where anything pushes

    def _believe(self) -> None:
        """Sets what is believed for the next wrenches."""
        self.believed = np.concatenate([part.ravel() for part in (self._sensing.by_parameters, self.theta, self._mass)])

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
        part, self.unfinished = self.unfinished, None
        match part:
            case SmoothingStage() if part.smoothing.left:
                self.unfinished = part._replace(smoothing=self.tracker.smoothed_on(part.smoothing, SLICE_MOMENTS))
            case SmoothingStage():
                self.unfinished = self._block_of(part)
            case Block():
                self.unfinished = self._row_of(part)
            case RowStage():
                self.unfinished = self._taken_in(*part)
            case HypothesisStage():
                self.unfinished = part.go_on()
            case UpdateStage():
                self.wrench_noise_scale, self.unfinished = part.with_noise_scale(self.wrench_noise_scale)
            case NoiseScaleStage():
                self.unfinished = self._decide(*part)
            case HypothesesStart():
                self.unfinished = self._begin(part.go_on())
            case DoneStage():
                self._conclude()

    def _finish(self) -> None:
        while self.unfinished is not None:
            self._go_on()

    def _take_row(self) -> None:
        """Works out the block that has been over for long enough, if there is one and motion was seen after it."""
        k, end = self.tracker.over()
        if not k:
            return
        if self.tracker.time[end - 1] <= self._seen_until:
            weighing = weights(self.tracker.time[:end], end - k)
            self.unfinished = SmoothingStage(k, end, weighing, self.tracker.smoothing(weighing.of_motion[:2]))
            self._go_on()
        elif self.time - self._seen_until > MAX_REGRESSION_GAP:
            self._drop_link()
            self._memory = self._memory.lost()
            self.tracker.drop(k)

    def followed(self, moments: int, before: float) -> int:
        """Kernels went on to so many moments with wrenches, of which the last but one was at a time; with them a row
        was due. Returns how many moments are left."""
        self.tracker.followed(moments)
        self.time = self._wrench_until = self.tracker.last_time
        self._seen_until = max(self._seen_until, self.tracker.seen_until)
        self._load_monitor.go_on(before)
        self._work(self.time - before, is_due=self.tracker.over()[0] > 0)
        return len(self.tracker.time)

    def _block_of(self, begun: SmoothingStage) -> Block | None:
        """A block that teaches something; none where the cart stood still, or nobody knows how it moved."""
        k, end, weighing, smoothing = begun
        tracker = self.tracker
        moved = self._memory.along(smoothing.smoothed, self.theta)
        wrenches, ahead = tracker.wrenches(end - 1, self.wrench_delay)
        is_slow = self._least_speed > 0 and is_slower(moved, self.cart, self._least_speed)
        is_whole = math.isfinite(ahead) and not tracker.is_torn(end - 1)
        is_still = stands_still(moved, self.cart)
        self._memory = self._memory.after(moved, k)
        tracker.drop(k)
        if is_whole and not is_slow and not is_still:
            return Block(weighing, moved, wrenches, ahead)
        self._drop_link(is_still=bool(is_whole and is_still))
        return None

    def _drop_link(self, *, is_still: bool = False) -> None:
        """The next block does not begin where the last one ended, or stood still."""
        self._belief.drop_link()
        self._taken = self._unscaled_rows = ()
        if self.hypotheses is not None:
            self._settle(self.hypotheses.without_link(is_still=is_still), self.time)
            self._conclude()

    def _row_of(self, block: Block) -> RowStage | None:
        """None where rows can't be learned from yet."""
        known = Gaussian(self.theta, self.covariance)
        row = filtered_row(self.cart, known, self._spread, block, self._unmodelled_noise)
        told = RowStage(float(block.moved.time[-1]), row, block.weights.of_white)
        return told if self._scale.is_known else self._with_scale(told, block)

    def _with_scale(self, told: RowStage, block: Block) -> RowStage | None:
        """The row, with which the last ones count at last, too; None while the scale is not known."""
        n = len(told.row.residual)
        self._scale = self._scale.after(block.weights.held @ block.wrenches[:, 1 : 1 + n], told.row)
        self._unscaled_rows = (*self._unscaled_rows, told)[-CHI2_TEST_ROWS:]
        if not self._scale.is_known:
            return None
        pending, self._unscaled_rows = self._unscaled_rows, ()
        for one in pending[:-1]:
            self._taken_in(*one)
        return told

    @property
    def _unmodelled_noise(self) -> UnmodelledNoise:
        """Open hypotheses, or what is known to push, leave no row quiet: it may bear as much as any."""
        level, one = self._level, self._one_disturbance
        usual = level.highest if self.hypotheses is not None or self._is_disturbed else level.mean_density
        return UnmodelledNoise(
            level.highest * one, usual * one, self.wrench_noise_scale.variance_factor, self._products.scaled
        )

    def _taken_in(self, time: float, row: FilteredRow, of_white: float) -> UpdateStage | HypothesisStage:
        """What the belief, or open hypotheses, make of a row."""
        if self.hypotheses is not None:
            return HypothesisStage(time, self.hypotheses.with_row(row, self.theta)).go_on()
        before = self._belief.copy()
        innovation = self._belief.update(row, self.theta)
        if not self._is_disturbed:
            self._level = self._level.after(innovation, of_white * self._one_disturbance)
        self._taken = (*self._taken, LearnedRow(before, row, self.theta))[-CHI2_TEST_ROWS:]
        return UpdateStage(time, innovation)

    def _decide(self, time: float, told: Innovation | LoadHypotheses) -> DoneStage | HypothesesStart:
        """What a row says of loads and pushes."""
        if isinstance(told, LoadHypotheses):
            self._load_monitor.follow(time, told.innovation, is_pushed=told.is_pushed)
            self._settle(told, time)
            return DoneStage()
        root = self._root_of_load
        if not self._load_monitor.note(time, told, root, self.wrench_noise_scale):
            return DoneStage()
        floor = self._products.floor(self.theta)[np.ix_(self._free, self._free)]
        beginning = HypothesesStart.of(time, self._taken, root @ root.T, floor, self._push)
        self._taken = ()
        return beginning

    @property
    def _root_of_load(self) -> Array:
        """`root @ rootᵀ` (f, f) is the covariance of what a usual load changes."""
        return np.asarray((self._products.by_factors(self.theta) @ (float(self.theta[0]) * self._root))[self._free])

    def note_push(self) -> None:
        """Somebody who has heard more found that what surprised is no load."""
        self._finish()
        if self.hypotheses is not None:
            self._belief, self.hypotheses = self.hypotheses.pushed.belief.copy(), None
            self._load_monitor.note_decision(self.time, is_load=False)
            self._conclude()

    def note_load_change(self, since: float) -> None:
        """Somebody else found another load, no earlier than some s: that is believed, if it was thought of since; else
        what was learned of the body counts as little as after one of its own."""
        self._finish()
        if self.hypotheses is not None and self.hypotheses.time > since:
            self._belief = self.hypotheses.if_loaded
        else:
            self._belief.open(self._root_of_load @ self._root_of_load.T)
        self.hypotheses, self._taken = None, ()
        self.last_decision = self.last_load_change = self.time
        self._load_monitor.note_decision(self.time, is_load=True)
        self._conclude()

    def _begin(self, beginning: HypothesesStart) -> DoneStage | HypothesesStart:
        """Hypotheses on their way over the last rows, or at the last."""
        if beginning.left or beginning.hypotheses is None:
            return beginning
        self._settle(beginning.hypotheses, beginning.time)
        return DoneStage()

    def _settle(self, hypotheses: LoadHypotheses, time: float) -> None:
        """What is believed while a push and a load both are, and whether that is decided."""
        self.hypotheses, self._belief = None if hypotheses.is_over else hypotheses, hypotheses.belief
        if hypotheses.is_over:
            self.last_decision, self.last_load_change = time, time if hypotheses.is_loaded else self.last_load_change
        self._load_monitor.settle(time, hypotheses)

    def _conclude(self) -> None:
        """The parameters to linearise at and to report; where what is believed is no body, the most likely one is
        taken, and the belief stays as it is."""
        theta, self.covariance, self._spread, self.wrench_delay = self._belief.concluded()
        if len(self._free) and not self._limits.holds(theta):
            with suppress(DataError):  # where what is believed is beyond numbers, what was stays
                self.theta = self._limits.nearest(theta, self._free, self._belief.parameters.information)
            theta = self.theta
        self.theta, self._report, self.reported_covariance = theta, None, self._covariance_to_report()
        self._mass = self.cart.inverse(*self._at_rest, theta).by_acceleration
        self._believe()

    def _covariance_to_report(self) -> Array:
        """The covariance (p, p) that people are told: of all that is not excluded, and as innovations vary."""
        wide = None if self.hypotheses is None else self.hypotheses.not_excluded
        return self._load_monitor.excess * (self.covariance if wide is None else wide.concluded().covariance)

    @property
    def report(self) -> Mapping[str, ParameterEstimate]:
        """What is said of the parameters."""
        if self._report is None:
            self._report = self.reported(self.reported_covariance)
        return qualified_by_health(self._report, self._load_monitor.health)

    def reported(self, covariance: Array) -> Mapping[str, ParameterEstimate]:
        """What would be said of the parameters if they had a covariance (p, p)."""
        given = self.theta, covariance, self._free, self._first_variances
        return LazyParameters(partial(self.reporter.of_free, *given))
