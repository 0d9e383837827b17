"""Contacts that don't depend on what is felt: those that stay, and those that go round."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import final

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.roles import ContactChoice, ContactQuery

from ..contacts.contact_regions import DISTANCE_TOLERANCE


@final
class FixedContacts:
    """Every arm keeps its first candidate; hands nearer than `apart` (m) are refused."""

    def __init__(self, arms: Sequence[Arm], apart: float = 0.0) -> None:
        held = {arm.name: arm.contacts.first for arm in arms}
        _check_apart({name: point[None] for name, point in held.items()}, apart)
        self._choice = ContactChoice(held, "fixed")

    def contacts(self, query: ContactQuery) -> ContactChoice:
        return self._choice


@final
class PeriodicContacts:
    """Every arm goes to its next candidate point every `period` (s), as the paper varies its contact point; hands that
    come nearer than `apart` (m) are refused."""

    def __init__(self, arms: Sequence[Arm], period: float, apart: float = 0.0) -> None:
        if not period > 0:
            raise UsageError(f"contact switching: period {period} s is not positive")
        self._points = {arm.name: [np.array(p) for p in arm.contacts.points] for arm in arms}
        for name, points in self._points.items():
            if not points:
                raise UsageError(f"contact switching: arm {name} has no points to go round; list points of its segment")
        _check_apart({name: np.array(points) for name, points in self._points.items()}, apart)
        self._period = period

    def contacts(self, query: ContactQuery) -> ContactChoice:
        turn = int(query.time / self._period + 1e-9)
        held = {name: points[turn % len(points)] for name, points in self._points.items()}
        return ContactChoice(held, f"goes round every {self._period:g} s")


def _check_apart(points: Mapping[str, Array], distance: float) -> None:
    """Points (m, 3) by arm, round which all go in step."""
    for (one, p), (other, q) in combinations(points.items(), 2):
        turns = np.arange(np.lcm(len(p), len(q)))
        least = float(np.linalg.norm(p[turns % len(p)] - q[turns % len(q)], axis=1).min())
        if least < distance - DISTANCE_TOLERANCE:
            what = f"{one} and {other} come as near as {least:.3g} m, and min_hand_distance is {distance:g} m"
            raise UsageError(f"contacts: {what}; give these arms other points")
