"""Arms whose wrenches can't be used: none has come, nobody has said where the arm holds, they are no numbers, or far
beyond what pushes such a cart, as numbers are that stand for no reading (-9999)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from cartgrasp.wheels import GRAVITY

from ..sensor_check.suspicion import Suspicion
from .kernels.sensor_health import SENSOR_TIMEOUT
from .measured_motion import is_contact

MAX_WEIGHT_RATIO = 5.0
"""Times the weight of the cart as first guessed, N and N·m: no arm gives as much, be it to squeeze a cart."""


class ArmMonitor:
    """Notes of which arms there were wrenches and contacts so far, when, and whose last wrench was none. Arms may come
    in samples of their own."""

    def __init__(self, cart: CartModel, arms: Sequence[str] | None) -> None:
        self._asked, self._weight = arms, GRAVITY * cart.inertia.mass
        self._time, self._recorded, self._holding = -math.inf, dict[str, float](), set[str]()  # s, and s of the last
        self._sizes: dict[str, float] = {}  # of the last, N and N·m

    def within_range(self, measurement: Measurement) -> Measurement:
        """With numbers that are none for wrenches that are too large."""
        if not measurement.wrenches:
            return measurement
        too_large = []
        for arm, wrench in measurement.wrenches.items():
            fx, fy, *_, tz = np.asarray(wrench, dtype=float).tolist()
            size = self._sizes[arm] = math.hypot(fx, fy, tz)
            if size > MAX_WEIGHT_RATIO * self._weight:
                too_large.append(arm)
        if not too_large:
            return measurement
        nothing = dict.fromkeys(too_large, np.full(6, np.nan))
        return replace(measurement, wrenches={**measurement.wrenches, **nothing})

    def note(self, measurement: Measurement) -> None:
        self._time = max(self._time, measurement.time)
        for arm in measurement.wrenches:
            self._recorded[arm] = self._time
        for arm, contact in measurement.contacts.items():
            if arm not in self._holding and is_contact(contact):
                self._holding.add(arm)

    @property
    def suspicions(self) -> Iterator[Suspicion]:
        """One for each arm, in words that say what is missing."""
        for arm in sorted(self._recorded) if self._asked is None else self._asked:
            if arm not in self._recorded:
                others = ", ".join(sorted(self._recorded)) or "no arm"
                yield _missing(arm, f"no wrench of it has come; those that came are of {others}")
            elif arm not in self._holding:
                yield _missing(arm, f"its wrenches come without a contact; give contacts={{{arm!r}: (x, y, z)}} once")
            elif (silent := self._time - self._recorded[arm]) > SENSOR_TIMEOUT:
                yield _missing(arm, f"no wrench of it has come for {silent:.1f} s")
            elif math.isnan(size := self._sizes[arm]):
                yield _missing(arm, "its wrench is NaN: the sensor, or its driver, tells no number")
            elif size > MAX_WEIGHT_RATIO * self._weight:
                times = f"{size / self._weight:.2g} times the weight of the cart"
                yield _missing(arm, f"its wrench is {times}: that is no reading, or it is not in N and N·m")


def _missing(arm: str, words: str) -> Suspicion:
    return Suspicion("missing", arm, 1.0, None, f"{arm}: {words}")
