"""Contacts that don't depend on what is felt: those that stay, and those that go round."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.roles import ContactChoice, ContactQuery


@final
class FixedContacts:
    """Every arm keeps its first candidate."""

    def __init__(self, arms: Sequence[Arm]) -> None:
        self._choice = ContactChoice({arm.name: arm.contacts.first for arm in arms}, "fixed")

    def contacts(self, query: ContactQuery) -> ContactChoice:
        return self._choice


@final
class PeriodicContacts:
    """Every arm goes to its next candidate point every `period` (s), as the paper varies its contact point."""

    def __init__(self, arms: Sequence[Arm], period: float) -> None:
        if not period > 0:
            raise UsageError(f"contact switching: period {period} s is not positive")
        self._points = {arm.name: [np.array(p) for p in arm.contacts.points] for arm in arms}
        for name, points in self._points.items():
            if not points:
                raise UsageError(f"contact switching: arm {name} has no points to go round; list points of its segment")
        self._period = period

    def contacts(self, query: ContactQuery) -> ContactChoice:
        turn = int(query.time / self._period + 1e-9)
        held = {name: points[turn % len(points)] for name, points in self._points.items()}
        return ContactChoice(held, f"goes round every {self._period:g} s")
