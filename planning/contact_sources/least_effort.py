"""Contacts of least effort for the wrench that is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import final

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.frames import Array
from cartgrasp.roles import ContactChoice, ContactQuery

from ..plan import Plan
from ..planner import WrenchPlanner
from ..quadratic_program import OPTIMAL


@final
class LeastEffortContacts:
    """The arms regrasp where the planner finds the least effort for the wrench wanted (smoothed over the dwell),
    at most once a `dwell` (s), and only for a gain of `least_gain` (share of the effort). The planner is its own, not
    the controller's, which would take these trials for wrenches it gave."""

    def __init__(self, planner: WrenchPlanner, arms: Sequence[Arm], dwell: float, least_gain: float = 0.05) -> None:
        self._planner, self._dwell, self._least_gain = planner, dwell, least_gain
        points = {arm.name: arm.contacts.points for arm in arms}
        one_by_one = any(arm.postures for arm in arms) and not any(arm.contacts.segments for arm in arms)
        self._choices = [dict(zip(points, held, strict=True)) for held in product(*points.values())] * one_by_one
        self._held: dict[str, Array] = {arm.name: arm.contacts.first for arm in arms}
        self._wanted = np.zeros(3)
        self._last_time = 0.0
        self._has_begun = False
        self._due = dwell

    def warm_up(self) -> None:
        self._planner.warm_up()

    def contacts(self, query: ContactQuery) -> ContactChoice:
        time = query.time
        if not self._has_begun:
            self._begin(query.held)
        self._has_begun = True
        if np.isfinite(query.wrench_b).all():
            share = min(1.0, (time - self._last_time) / self._dwell * 3.0)
            self._wanted = self._wanted + share * (np.asarray(query.wrench_b) - self._wanted)
            self._last_time = time
        if time >= self._due - 1e-9:
            self._due = time + self._dwell
            self._regrasp()
        return ContactChoice(self._held, "least effort")

    def _begin(self, held: Mapping[str, Array]) -> None:
        """Where hands hold already, else at first candidates; elsewhere where limits or other hands forbid that."""
        self._held = dict(held) or self._held
        if self._planner.plan(self._wanted, contacts=self._held).status != OPTIMAL:
            self._regrasp()

    def _regrasp(self) -> None:
        free = self._freest()
        held = self._planner.plan(self._wanted, contacts=self._held)
        if free.status != OPTIMAL:
            return
        least = (1.0 - self._least_gain) * (held.effort if held.effort is not None else np.inf)
        if free.effort is not None and free.effort < least:
            self._held = {name: np.array(point) for name, point in free.contacts.items()}

    def _freest(self) -> Plan:
        """The plan at the best contacts; where limits change with them, each choice is planned with its own."""
        if not self._choices:
            return self._planner.plan(self._wanted)
        plans = [self._planner.plan_or_hold(self._wanted, contacts=held) for held in self._choices]
        return min(plans, key=lambda plan: np.inf if plan.status != OPTIMAL or plan.effort is None else plan.effort)
