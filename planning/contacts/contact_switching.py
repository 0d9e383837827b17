"""Where the arms hold during a run: who decides, and how often."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import final

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from ..planner import WrenchPlanner


@final
class FixedContacts:
    """Every arm keeps its first candidate."""

    def __init__(self, arms: Sequence[Arm]) -> None:
        self._contacts = {arm.name: arm.contacts.first for arm in arms}

    def contacts(self, time: float, wrench_b: Array) -> Mapping[str, Array]:
        return self._contacts


@final
class PeriodicContacts:
    """Every arm goes to its next candidate point every `period` (s), as the paper varies its contact point."""

    def __init__(self, arms: Sequence[Arm], period: float) -> None:
        if not period > 0:
            raise UsageError(f"contact switching: period {period} s is not positive")
        self._points = {arm.name: [np.array(p) for p in arm.contacts.points] for arm in arms}
        self._period = period

    def contacts(self, time: float, wrench_b: Array) -> Mapping[str, Array]:
        turn = int(time / self._period + 1e-9)
        return {name: points[turn % len(points)] for name, points in self._points.items()}


@final
class LeastEffortContacts:
    """The arms regrasp where the planner finds the least effort for the wrench wanted (smoothed over the dwell),
    at most once a `dwell` (s), and only for a gain of `least_gain` (share of the effort). The planner is its own, not
    the controller's, which would take these trials for wrenches it gave."""

    def __init__(self, planner: WrenchPlanner, arms: Sequence[Arm], dwell: float, least_gain: float = 0.05) -> None:
        self._planner, self._dwell, self._least_gain = planner, dwell, least_gain
        self._held: dict[str, Array] = {arm.name: arm.contacts.first for arm in arms}
        self._wanted = np.zeros(3)
        self._last_time = 0.0
        self._due = dwell

    def contacts(self, time: float, wrench_b: Array) -> Mapping[str, Array]:
        share = min(1.0, (time - self._last_time) / self._dwell * 3.0)
        self._wanted = self._wanted + share * (np.asarray(wrench_b) - self._wanted)
        self._last_time = time
        if time >= self._due - 1e-9:
            self._due = time + self._dwell
            self._regrasp()
        return self._held

    def _regrasp(self) -> None:
        free = self._planner.plan(self._wanted)
        held = self._planner.plan(self._wanted, contacts=self._held)
        if free.status != "optimal":
            return
        least = (1.0 - self._least_gain) * (held.effort if held.effort is not None else np.inf)
        if free.effort is not None and free.effort < least:
            self._held = {name: np.array(point) for name, point in free.contacts.items()}
