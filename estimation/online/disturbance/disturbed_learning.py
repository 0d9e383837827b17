"""Learning beside an observer of what no model explains, which keeps that from the parameters.

What pushes beside the arms is taken for friction, or for another load, by whatever learns from the arms alone. So
samples reach what learns a little late, and without their wrenches where meanwhile something was seen to push: of such
a time the total wrench is not known, and nothing is learned from it. That is so where the disturbance is no noise, and
neither what is not known of the parameters nor a usual load that was put on would look like it, by how the arms and the
cart agree to accelerate. What goes on for too long is the model's error, and is learned from. What is too weak to be
seen, the observer's own deviation for as long as its answer takes, is noise to what learns, which finds out how much of
it there is as a rule (`regressor/disturbance_level.py`).

A load that was put on is not over with what shows of it. So from the first sample whose wrench is kept back another
learns from all that there is, until its hypotheses (`regressor/load_hypotheses.py`) are decided. If it finds a load, it
was right.

And what is noise to what learns may be a load that is too small to be seen as a push. One that learns with the noise of
the sensors alone, as a `CartFilter` does, finds it soon. Its word is taken where nothing was kept back meanwhile.

While one of the others tries a load, or has found one that nobody else has, parameters are told as unsure as that one
is. What is told of the disturbance, and fed forward, comes from a quicker observer than the one that learning hears.

Where nothing is seen of the motion any more, nobody knows what pushes: by then what pushed is forgotten. Else it would
move the predicted cart for ever, and whoever tracks that would push the real one the other way.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Self

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.motion import Disturbance, Estimate, Measurement
from cartgrasp.shallow_copy import shallow_copy

from ...gaussian import Gaussian
from ...health import Health
from ...parameter_report import qualified_by_health
from ..arguments import EstimatorArguments
from ..cart_filter import core_of
from ..kernels.measured_wrench import WRENCH_HOLD_TIME
from ..kernels.sensor_health import SENSOR_TIMEOUT
from ..learning_filter import LearningFilter
from ..measured_motion import usable
from ..regressor.wrench_noise_scale import WrenchNoiseScale
from ..unknown_slope import with_unknown_slope
from ..wrench_sensing import Moving, WrenchSensing
from .observer import DisturbanceObserver, Observed

DISTURBANCE_ONSET_CHI2, DISTURBANCE_END_CHI2 = (10.8, 13.8, 16.3), (3.8, 6.0, 7.8)
"""By dimension, of the normalised square: chi-squared with one, two and three components is beyond the first once in a
thousand times, and beyond the second, below which a disturbance is over, once in twenty."""
FEEDFORWARD_RESPONSE_RATIO = 0.6
"""Share of the response in which what is told, and fed forward, follows. It is noisier, which arms bear; what learns
hears the slower one."""
MAX_ROW_DELAY = 0.4
"""s until the last row in which a sample counts is worked out."""
MAX_DISTURBANCE_DURATION = 10.0
"""s after which what pushes is the model's error, and what is no load by then is none."""
MAX_DISTURBED_SHARE = 0.5
"""Share of the last seconds, with `MAX_DISTURBANCE_DURATION` as time constant, beyond which what pushes is no
disturbance of what the model explains: nobody knows which of them is right."""


# Many methods: what every filter of samples has, and one for each of those that learn and observe here.
class DisturbedLearning:
    """Observers see each sample at once, learners a `response` (s) later. Samples come in the order of their times;
    `LateSamples` sees to that."""

    def __init__(self, made_of: EstimatorArguments, response: float) -> None:
        made_of = with_unknown_slope(made_of)
        cart, arms, noise, prior, yaws = made_of
        self.cart, self.prior, self.response = cart, prior, response
        self._observer = self._as_declared = DisturbanceObserver(cart, noise, response, prior)
        self._ahead = replace(self._observer, response=FEEDFORWARD_RESPONSE_RATIO * response)
        unseen = self._observer.deviation * math.sqrt(response)
        self._careful = core_of(made_of, unseen=unseen)
        self._quick = core_of(made_of)
        self._undecided_since = self._quick_load_change = -math.inf  # s, of the quick one
        self._open: LearningFilter | None = None  # learns from what is kept back, too
        self._open_since = self._kept_back_at = -math.inf  # s
        self._sensing = WrenchSensing(cart, arms, yaws, noise.wrench_covariance)
        self._waiting: tuple[Measurement, ...] = ()
        self._careful_estimate: Estimate | None = None
        self._observed: tuple[Observed, Observed] | None = None  # and by the quicker one
        self._disturbance: Disturbance | None = None
        self._is_sure, self._is_total_known = False, not arms  # declared ones may push before they tell
        self._total_known_at = math.inf  # s: when all arms' wrenches were known last; inf: never
        self._seen_at, self._is_unseen = -math.inf, False  # s, when something was seen of the motion; not for too long
        self._acts_since = -math.inf  # when the disturbance set in that acts now, or acted last
        self._acted_until = -math.inf  # when one acted last
        self._disturbed_share = 0.0
        self.time = -math.inf

    @property
    def took_long(self) -> bool:
        return any(one.took_long for one in (self._careful, self._quick, self._open) if one is not None)

    @property
    def wrench_noise_scale(self) -> WrenchNoiseScale:
        return self._quick.wrench_noise_scale

    def take(self, measurement: Measurement) -> None:
        """Observes to the measurement's time, and lets what learns have what is old enough."""
        self._sensing.note_contacts(measurement)  # the sample waits; where arms hold, the observers need now
        self._count_disturbed(measurement.time)
        self.time = measurement.time
        self._waiting = (*self._waiting, measurement)
        until = math.inf if self._careful_estimate is None else measurement.time - self.response
        while self._waiting and self._waiting[0].time <= until:
            first, self._waiting = self._waiting[0], self._waiting[1:]
            self._learn(first)
        self._careful_estimate = self._careful.estimate()
        self._observe(measurement, self._careful_estimate)

    def _count_disturbed(self, time: float) -> None:
        """Up to a time, while a disturbance acts or not."""
        if self._disturbance is not None:
            share = 1.0 - math.exp(-max(time - self.time, 0.0) / MAX_DISTURBANCE_DURATION)
            self._disturbed_share += share * (self._disturbance.acts - self._disturbed_share)

    def scale_noise(self, noise_factors: Array) -> None:
        for one in (self._careful, self._quick, self._open):
            if one is not None:
                one.scale_noise(noise_factors)
        self._observer = replace(self._as_declared, noise=self._as_declared.noise.scaled(noise_factors))
        self._ahead = replace(self._observer, response=self._ahead.response)

    def copy(self) -> Self:
        other = shallow_copy(self)
        other._careful, other._quick = self._careful.copy(), self._quick.copy()
        other._sensing = self._sensing.copy()
        other._open = None if self._open is None else self._open.copy()
        return other

    def predicted_through(self, samples: Sequence[Measurement]) -> Self:
        """A copy whose observers have seen later motion, and that learned nothing."""
        other, told = shallow_copy(self), self._careful_estimate
        assert told is not None  # a sample has come
        for sample in samples:
            other.time = sample.time
            other._observe(sample, told)
        return other

    def estimate(self) -> Estimate:
        told, observed, disturbance = self._careful_estimate, self._observed, self._disturbance
        assert told is not None  # a sample has come
        if observed is None or disturbance is None:
            return told._replace(time=self.time)
        health, is_silent = told.health, self.time - self._total_known_at > SENSOR_TIMEOUT
        if health == Health.NO_WRENCH and math.isfinite(self._total_known_at) and not is_silent:
            # Wrenches are there, and wait, or are kept back: what rows say holds.
            health = self._careful.learner.learned.health
            health = Health.OUTLIERS if health == Health.OK and math.isfinite(self._kept_back_at) else health
        elif is_silent and health in (Health.OK, Health.OUTLIERS, Health.LOAD_CHANGED):
            health = Health.NO_WRENCH
        told = self._doubted(told)
        if self._disturbed_share > MAX_DISTURBED_SHARE and health != Health.STALE:
            health = Health.INCONSISTENT
            told = told._replace(parameters=qualified_by_health(told.parameters, health))
        return told._replace(
            time=observed[0].time,
            motion=observed[0].motion(told.motion.memory),
            health=health,
            disturbance=disturbance,
        )

    def _doubted(self, told: Estimate) -> Estimate:
        """What pushes may be a load while one of the others tries that, or the quick one has found one that nobody else
        has: then it is as unsure what the parameters are as that one is, from what is told."""
        own, quick, widest = self._careful.learner.learned, self._quick.learner.learned, told.covariance
        is_found = quick.last_load_change > max(own.last_load_change, self.time - MAX_DISTURBANCE_DURATION)
        others = [(quick, is_found or (quick.hypotheses is not None and self._undecided_since > own.last_load_change))]
        if self._open is not None:
            tried = self._open.learner.learned
            others.append((tried, tried.hypotheses is not None and self._open_since > own.last_load_change))
        for other in (one for one, doubts in others if doubts):
            off = other.theta - own.theta
            spread = other.reported_covariance + np.outer(off, off)
            widest = spread if widest is None or spread[0, 0] > widest[0, 0] else widest
        if widest is None or widest is told.covariance:
            return told
        return told._replace(parameters=own.reported(widest), covariance=widest)

    # --- learning ---------------------------------------------------------------------------------------------

    def _learn(self, sample: Measurement) -> None:
        self._careful.learner.note_disturbance(sample.time < self._acted_until + MAX_ROW_DELAY)
        may_be_push = self._acted_until - self._acts_since < MAX_DISTURBANCE_DURATION
        if may_be_push and sample.time <= self._acted_until and sample.wrenches:
            if self._open is None:
                self._open, self._open_since = self._careful.copy(), sample.time
                self._open.learner.note_disturbance(True)
            self._kept_back_at = sample.time
            kept_back = {arm: np.full(6, np.nan) for arm in sample.wrenches}
            self._careful.take(replace(sample, wrenches=kept_back))
        else:
            self._careful.take(sample)
        if self._open is not None:
            self._let_open_learn(self._open, sample)
        self._let_quick_learn(sample)

    def _let_quick_learn(self, sample: Measurement) -> None:
        """What the quick one makes of a sample, and whether its word on a load is taken: where nothing was kept back
        meanwhile, or whoever has heard the most of what was deems a load the likeliest, too."""
        self._quick.take(sample)
        quick, since = self._quick.learner.learned, self._undecided_since
        if quick.hypotheses is not None:
            return
        if quick.last_load_change > self._quick_load_change:
            self._quick_load_change = quick.last_load_change
            judge = (self._open or self._careful).learner
            hypotheses = judge.learned.hypotheses
            may_be_load = hypotheses is not None and hypotheses.may_be_load
            if judge.learned.last_load_change < since and (self._kept_back_at < since or may_be_load):
                judge.note_load_change(since - MAX_ROW_DELAY)
                self._go_on_with_open()
        self._undecided_since = sample.time

    def _let_open_learn(self, other: LearningFilter, sample: Measurement) -> None:
        """What learns from all samples, until it is known whether there is another load. What others think of that,
        who have heard less, ends as soon as this one is sure of a push."""
        other.take(sample)
        tried, careful = other.learner.learned, self._careful.learner
        if tried.last_load_change > self._open_since:
            self._go_on_with_open()
        elif tried.last_decision > self._open_since or sample.time - self._kept_back_at > MAX_DISTURBANCE_DURATION:
            self._open = None
        elif careful.learned.hypotheses and tried.hypotheses and tried.hypotheses.is_surely_pushed:
            careful.note_push()

    def _go_on_with_open(self) -> None:
        """It was right."""
        if self._open is not None:
            self._careful, self._open, self._acted_until = self._open, None, -math.inf

    # --- observing --------------------------------------------------------------------------------------------

    def _observe(self, measurement: Measurement, told: Estimate) -> None:
        pose, velocity = (
            np.full(3, np.nan) if part is None else usable(part) for part in (measurement.pose, measurement.velocity)
        )
        if self._observed is None:
            if not np.isfinite(pose).all():
                return
            start = self._observer.start(measurement.time, pose)
            self._observed = start, start
        theta, memory = told.model_parameters, told.motion.memory
        memory = memory if memory is not None else np.zeros(0)
        moves, was_unseen = bool(np.isfinite(pose).any() or np.isfinite(velocity).any()), self._is_unseen
        self._seen_at = measurement.time if moves else self._seen_at
        self._is_unseen = measurement.time - self._seen_at > SENSOR_TIMEOUT
        observed = []
        for observer, was in zip((self._observer, self._ahead), self._observed, strict=True):
            now = observer.advanced(was, measurement.time, memory, theta)
            observed.append(observer.seen(now, pose, velocity) if moves else now)
        if self._is_unseen and not was_unseen:
            observed = [self._observer.forgotten(one) for one in observed]
            self._disturbance = self._observer.unknown
        sensed, was_known = None, self._is_total_known
        if measurement.wrenches:
            moving = Moving(observed[0].state(memory), measurement.time)
            sensed = self._sensing.sense(measurement, theta, moving)
        if sensed is not None:
            self._total_known_at, self._is_total_known = measurement.time, True
            observed = [one if was_known else self._observer.forgotten(one) for one in observed]
            observed = [self._observer.pushed(one, sensed.value, sensed.covariance) for one in observed]
        elif measurement.wrenches or measurement.time - self._total_known_at > WRENCH_HOLD_TIME:
            self._is_total_known = False
        self._observed = observed[0], observed[1]
        if self._disturbance is None or moves:
            self._conclude(observed[0], observed[1].wrench, told, memory)

    def _conclude(self, observed: Observed, ahead: Gaussian, told: Estimate, memory: Array) -> None:
        """Whether the disturbance acts, which is told as it is `ahead`; nobody knows where not all arms tell what they
        give. It does for sure where no usual load would look like it, and goes on to until a load that rolls on could;
        else where no load would by its inertia. A load does not turn nu' round: it explains the part that wrenches
        alone would make, and that is there."""
        time, k, was = observed.time, observed.k, self._disturbance is not None and self._disturbance.acts
        unknown = self._careful.learner.learned.covariance
        squares, known = self._observer.squares(observed, memory, told.model_parameters, unknown)
        rolls, agreed, rigid = squares
        begins, stays = DISTURBANCE_ONSET_CHI2[k - 1], DISTURBANCE_END_CHI2[k - 1]
        self._is_sure = rolls > stays if self._is_sure else agreed > begins
        acts = self._is_total_known and (self._is_sure or rigid > (stays if was else begins))
        if acts:
            self._acts_since, self._acted_until = (self._acts_since if was else time), time
        if not self._is_total_known:
            self._disturbance = self._observer.unknown
            return
        known = known + ahead.covariance - observed.wrench.covariance
        self._disturbance = Disturbance(ahead.mean, known, acts)
