"""What online estimators have in common: samples in whatever order, and a monitor of the sensors."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from contextlib import suppress
from dataclasses import replace
from typing import ClassVar, Generic, TypeVar

from cartgrasp.checks import brief
from cartgrasp.errors import CartgraspError, UsageError
from cartgrasp.garbage_collection import freeze_live_objects
from cartgrasp.motion import Estimate, Measurement, Motion
from cartgrasp.tracked_point import TrackedPoint

from ..health import Health
from ..parameter_report import qualified_by_health
from ..sensor_check.suspicion import REFUSED_KINDS, Suspicion
from .arguments import EstimatorArguments, check_measurement, owned
from .arm_monitor import ArmMonitor
from .clock_monitor import ClockMonitor
from .frozen_wrenches import FrozenWrenches
from .late_samples import LateSamples, SampleFilter
from .repeated_poses import RepeatedPoses
from .repeated_velocities import RepeatedVelocities
from .sensor_monitor import SensorMonitor
from .unknown_slope import without_slope
from .warming import synthetic_push

SLOW_LOOP_INTERVAL = 0.02
"""s between samples: a loop that is slower has time for all that is to be done with each."""

C = TypeVar("C", bound=SampleFilter)


class OnlineEstimator(ABC, Generic[C]):
    """Brings each sample to where it belongs, and qualifies what is told by what is suspected of the sensors."""

    aligns: ClassVar[bool]
    """Whether wrenches of a `time_delay` are brought back to when they were felt."""

    def __init__(self, made_of: EstimatorArguments, core: C) -> None:
        self.cart, self.arms, self.noise, self.prior, _ = made_of
        self._tracked, self._sensor_monitor = TrackedPoint(self.cart.pose_tb), SensorMonitor(*made_of)
        self._samples, self._clock_monitor = LateSamples(core), ClockMonitor()
        self._repeated_poses, self._repeated_velocities = RepeatedPoses(), RepeatedVelocities()
        self._frozen_wrenches, self._arm_monitor = FrozenWrenches(), ArmMonitor(self.cart, self.arms)
        self._motion: Motion | None = None  # as told last

    @abstractmethod
    def _core_estimate(self) -> Estimate:
        """What is known at the time of the newest sample."""

    def update(self, measurement: Measurement) -> Estimate:
        """Predicts to the measurement's time, takes in what it holds, and says what is known. Of a late one, what is
        known at the time of the newest; one that is too late is left out (`clock_went_back`)."""
        check_measurement(measurement)
        samples, monitor = self._samples, self._sensor_monitor
        sample = self._tracked.at_body(samples.on_steady_clock(owned(measurement)))
        sample = self._repeated_velocities.without_repeats(self._repeated_poses.without_repeats(sample, self._motion))
        sample = self._frozen_wrenches.without_frozen(self._arm_monitor.within_range(sample))
        newest_before = samples.state.time
        is_taken = samples.take(sample)
        self._clock_monitor.note(sample)
        self._arm_monitor.note(sample)
        now = measurement.time + samples.clock_offset
        if is_taken:
            monitor.samples.note(sample if sample.time == now else replace(sample, time=now), samples.state.time)
        is_slow = not now - newest_before < SLOW_LOOP_INTERVAL
        is_free = now >= monitor.samples.due and (is_slow or (now > newest_before and not samples.state.took_long))
        if is_free and monitor.go_on(now, at_once=is_slow):
            samples.scale_noise(monitor.noise_factors)
        found = self.estimate
        self._motion = found.motion
        return found if is_taken else found._replace(health=Health.CLOCK)

    def warm_up(self) -> None:
        """Does now, with a filter like this one, what would cost at the first updates: kernels are loaded in a second,
        or compiled, in a minute, the very first time on a machine. What this one has learned stays. What lives by then
        is no more looked at by the interpreter's collector of garbage, which would pause for 80 ms."""
        import scipy.optimize  # noqa: F401  for estimates that are no body

        # Other arguments compile nothing else.
        other = type(self)(self.cart, self.arms, noise=self.noise, prior=self.prior)  # type: ignore[call-arg, arg-type]
        if self.cart.is_compiled:
            self.cart.dynamics.warm_up()
        if self.cart.wheels:
            self.cart.wheel_set.loads(self.cart.inertia.phi)
        with suppress(CartgraspError):  # what is believed may be far from the push that is made up
            for sample in synthetic_push(self.cart, self.arms or ("arm",)):
                other.update(sample)
        freeze_live_objects()

    @property
    def estimate(self) -> Estimate:
        found, offset = without_slope(self._core_estimate(), self.cart), self._samples.clock_offset
        of_clock = self._clock_monitor.suspicions
        if of_clock or self._clock_monitor.is_apart:
            found = found._replace(health=Health.STALE)
        suspicions = of_clock + self._sensor_monitor.suspicions
        if found.health == Health.NO_WRENCH:
            suspicions = (*suspicions, *self._arm_monitor.suspicions, *self._frozen_wrenches.suspicions)
        if found.health != Health.INCONSISTENT:  # under a model that does not fit, nobody knows what is noise
            suspicions += self._samples.state.wrench_noise_scale.suspicions
        if suspicions:
            found = qualified(found, suspicions)
        return found._replace(time=found.time - offset) if offset else found

    @property
    def _core(self) -> C:
        if self._samples.state.time == -math.inf:
            raise UsageError("filter: no measurement has come yet")
        return self._samples.state

    def __repr__(self) -> str:
        seen = "no measurement yet" if self._samples.state.time == -math.inf else repr(self.estimate)
        return brief(type(self).__name__, self.cart.name, seen)


def qualified(estimate: Estimate, suspicions: tuple[Suspicion, ...]) -> Estimate:
    """With what is suspected: under a wrong sign or unit nothing was taught, and nothing is `ok`."""
    health = Health(estimate.health)
    if any(one.kind in REFUSED_KINDS for one in suspicions) and health not in (Health.STALE, Health.NO_WRENCH):
        health = Health.INCONSISTENT
    parameters = qualified_by_health(estimate.parameters, health)
    return estimate._replace(health=health, parameters=parameters, suspicions=suspicions)
