"""Sensors that record wrenches a known while after they were felt: the filter runs that much behind, and looks ahead.

What is recorded at t was felt at `t - delay`. So motion is held back until the wrench of its time has come. What is
said of the motion now is what the filter believes once it has seen what is held, too, of which no wrench tells yet.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Generic, Protocol, Self, TypeVar

from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement
from cartgrasp.shallow_copy import shallow_copy

from .kernels.measured_wrench import WRENCH_HOLD_TIME
from .late_samples import TIME_TOLERANCE, SampleFilter
from .regressor.wrench_noise_scale import WrenchNoiseScale


def longest_delay(cart: CartModel) -> float:
    """The longest delay of the wrenches of any arm, s."""
    return max((cart.lateness(effect.label) for effect, _ in cart.sensor_effects), default=0.0)


class AnticipatingFilter(SampleFilter, Protocol):
    """A filter that can look ahead through motion of which no wrench tells yet."""

    def estimate(self) -> Estimate: ...

    def predicted_through(self, samples: Sequence[Measurement]) -> Self:
        """A copy that has seen later motion, and learned nothing."""
        ...


C = TypeVar("C", bound=AnticipatingFilter)


def with_delays_removed(core: C, cart: CartModel) -> DelayedWrenches[C] | C:
    """The core, wrapped so that wrenches count when they were felt, where the cart says that they come late."""
    return DelayedWrenches(core, cart) if longest_delay(cart) > 0 else core


class DelayedWrenches(Generic[C]):
    """Wraps a core, which is behind by the delay of the cart's slowest sensor. A copy of it has seen held motion, too,
    and looks ahead."""

    def __init__(self, core: C, cart: CartModel) -> None:
        self.core, self._cart, self._delay = core, cart, longest_delay(cart)
        self._held_motion: tuple[Measurement, ...] = ()
        self._recorded_wrenches: tuple[Measurement, ...] = ()
        self._looking_ahead: C | None = None
        self.time = core.time

    @property
    def took_long(self) -> bool:
        return self.core.took_long

    @property
    def wrench_noise_scale(self) -> WrenchNoiseScale:
        return self.core.wrench_noise_scale

    def take(self, measurement: Measurement) -> None:
        core, self._looking_ahead, self.time = self.core, None, measurement.time
        felt_at = self.time - self._delay
        self._held_motion = (*self._held_motion, replace(measurement, wrenches={}))
        while self._held_motion and (self._held_motion[0].time <= felt_at + TIME_TOLERANCE or core.time == -math.inf):
            first, self._held_motion = self._held_motion[0], self._held_motion[1:]
            core.take(first)
        if measurement.wrenches:
            recorded = [one for one in self._recorded_wrenches if one.time > felt_at - TIME_TOLERANCE]
            self._recorded_wrenches = (*recorded, measurement)
            if felt_at > core.time - TIME_TOLERANCE:
                core.take(Measurement(max(felt_at, core.time), wrenches=self._felt_together(measurement)))

    def scale_noise(self, noise_factors: Array) -> None:
        self.core.scale_noise(noise_factors)

    def copy(self) -> Self:
        other = shallow_copy(self)
        other.core = self.core.copy()
        return other

    def estimate(self) -> Estimate:
        now = self.ahead.estimate()
        return self.core.estimate()._replace(time=self.time, motion=now.motion, health=now.health)

    @property
    def ahead(self) -> C:
        """What has seen the motion that is held, too."""
        if self._looking_ahead is None:
            self._looking_ahead = self.core.predicted_through(self._held_motion)
        return self._looking_ahead

    def _felt_together(self, last: Measurement) -> dict[str, Array]:
        """For each arm, the sample that was felt when those of the slowest sensor were."""
        felt = {}
        for arm in last.wrenches:
            wanted = self.time - self._delay + self._cart.lateness(arm)
            recorded = (one for one in self._recorded_wrenches if arm in one.wrenches)
            nearest = min(recorded, key=lambda one: abs(one.time - wanted))
            if abs(nearest.time - wanted) < WRENCH_HOLD_TIME:
                felt[arm] = nearest.wrenches[arm]
        return felt
