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
from .measured_motion import is_contact

MAX_WEIGHT_RATIO = 5.0
"""Times the weight of the cart as first guessed, N and N·m: no arm gives as much, be it to squeeze a cart."""


class ArmMonitor:
    """Notes of which arms there were wrenches and contacts so far, and which are none in the last sample."""

    def __init__(self, cart: CartModel, arms: Sequence[str] | None) -> None:
        self._asked, self._weight = arms, GRAVITY * cart.inertia.mass
        self._recorded, self._holding = set[str](), set[str]()
        self._too_large: dict[str, float] = {}
        self._not_numbers: tuple[str, ...] = ()

    def within_range(self, measurement: Measurement) -> Measurement:
        """With numbers that are none for wrenches that are too large."""
        if not measurement.wrenches:
            return measurement
        sizes = {arm: math.hypot(wrench[0], wrench[1], wrench[5]) for arm, wrench in measurement.wrenches.items()}
        self._too_large = {arm: size for arm, size in sizes.items() if size > MAX_WEIGHT_RATIO * self._weight}
        self._not_numbers = tuple([arm for arm, size in sizes.items() if math.isnan(size)])
        if not self._too_large:
            return measurement
        nothing = dict.fromkeys(self._too_large, np.full(6, np.nan))
        return replace(measurement, wrenches={**measurement.wrenches, **nothing})

    def note(self, measurement: Measurement) -> None:
        self._recorded |= measurement.wrenches.keys()
        self._holding |= {arm for arm, contact in measurement.contacts.items() if is_contact(contact)}

    @property
    def suspicions(self) -> Iterator[Suspicion]:
        """One for each arm, in words that say what is missing."""
        for arm in sorted(self._recorded) if self._asked is None else self._asked:
            if arm not in self._recorded:
                others = ", ".join(sorted(self._recorded)) or "no arm"
                yield _missing(arm, f"no wrench of it has come; those that came are of {others}")
            elif arm not in self._holding:
                yield _missing(arm, f"its wrenches come without a contact; give contacts={{{arm!r}: (x, y, z)}} once")
        for arm in self._not_numbers:
            yield _missing(arm, "its wrench is NaN: the sensor, or its driver, tells no number")
        for arm, size in self._too_large.items():
            times = f"{size / self._weight:.2g} times the weight of the cart"
            yield _missing(arm, f"its wrench is {times}: that is no reading, or it is not in N and N·m")


def _missing(arm: str, words: str) -> Suspicion:
    return Suspicion("missing", arm, 1.0, None, f"{arm}: {words}")
