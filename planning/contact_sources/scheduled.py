"""Contacts by a schedule over a horizon, which is made anew as the estimate changes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import final

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.model import CartModel
from cartgrasp.roles import ContactChoice, ContactQuery, ReferencePath

from ..control.hand import RegraspTimes
from ..excitation.excitation_family import contact_choices
from ..quadratic_program import OPTIMAL
from ..schedule.schedule import Grip, Horizon, RegraspCost, Schedule, plan_schedule
from ..schedule.stage_efforts import candidate_points
from .choosing import Choosing
from .lookahead import SAME_CHOICE_DISTANCE

HORIZON_STAGES = 20
"""The number of stages of a horizon."""


@final
class ScheduledContacts:
    """The schedule of least effort for the time `ahead`, made anew each `every` s, while no hand is on its way, for the
    cart as then estimated."""

    def __init__(
        self, cart: CartModel, arms: Sequence[Arm], reference: ReferencePath, choosing: Choosing, regrasp: RegraspTimes
    ) -> None:
        self._cart, self._arms, self._reference, self._choosing = cart, list(arms), reference, choosing
        self._points = candidate_points(arms)
        farthest = (math.dist(*pair) for points in self._points.values() for pair in combinations(points, 2))
        self._cost = RegraspCost(regrasp.lasting(max(farthest, default=0.0)), choosing.regrasp_effort)
        self._schedule: Schedule | None = None
        first = contact_choices(arms, choosing.min_hand_distance)[0]
        self._chosen, self._due = ContactChoice(dict(zip(self._points, first, strict=True))), -np.inf

    def contacts(self, query: ContactQuery) -> ContactChoice:
        if query.time >= self._reference.duration - SAME_CHOICE_DISTANCE:
            if self._schedule is None and query.held:
                return self._chosen._replace(contacts=query.held)
        elif query.time >= self._due - 1e-9:
            self._plan(query)
        if self._schedule is not None:
            grips = self._schedule.grips(query.time)
            self._chosen = self._chosen._replace(contacts={name: grip.contact for name, grip in grips.items()})
        return self._chosen

    def _plan(self, query: ContactQuery) -> None:
        held = {name: Grip(point) for name, point in query.held.items()}
        if any(
            np.abs(self._points[name] - grip.contact).max(axis=1).min() > SAME_CHOICE_DISTANCE
            for name, grip in held.items()
        ):
            return  # a hand is on its way
        self._due = query.time + self._choosing.every
        length, apart = self._choosing.ahead, self._choosing.min_hand_distance
        horizon = Horizon(query.time, length / HORIZON_STAGES, held or None, apart, length)
        cart = self._cart if query.estimate is None else query.estimate.cart()
        if self._schedule is None and held:
            self._chosen = self._chosen._replace(contacts=query.held)
        found = plan_schedule(self._reference, cart, self._arms, self._cost, horizon)
        if found.status == OPTIMAL:
            self._schedule = found
            self._chosen = self._chosen._replace(why="least effort of the schedule")
        else:
            words = found.blocked[0].words if found.blocked else found.status
            self._chosen = self._chosen._replace(why=f"no schedule: {words}")
