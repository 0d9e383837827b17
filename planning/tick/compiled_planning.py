"""What `WrenchPlanner` has compiled: allocations at given contacts, choice among this tick's candidates, and plans of
both. Whatever isn't covered, refused or not proven here is for the general road to answer."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from itertools import combinations
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.contacts import LARGEST_POSITION
from cartgrasp.frames import Array

from ..allocation.allocation_template import AllocationTemplate
from ..allocation.duality import least_cost
from ..contacts.contact_bounds import Candidates
from ..contacts.contact_choice import Choice, SearchLimit
from ..contacts.contact_regions import DISTANCE_TOLERANCE
from ..contacts.switching_cost import Switching
from ..objectives import Cost
from ..plan import ChoiceProof, Figures, Plan
from ..quadratic_program import OPTIMAL, LimitNames, QPSolution, QuadraticProgram, Residuals, active_limits
from .compiled_allocation import SOLVER, CompiledAllocation, Point
from .compiled_choice import CompiledChoice
from .given_contacts import REACH_TOLERANCE
from .plan_inputs import real_numbers
from .terms import Terms

N_RESIDUALS = len(Residuals._fields)


class CompiledPlanning:
    """Plans for the candidates of `terms`; others need a new one. `last` are the wrenches (6n,) and contacts of the
    last plan."""

    def __init__(self, terms: Terms, allocation: CompiledAllocation) -> None:
        self._terms, self._allocation, self._own = terms, allocation, terms.candidates
        self._reaching = terms.reaching(terms.sets)
        own = self._own.single
        self._own_points = None if own is None or self._is_refused(own) else own
        self._given, self._given_points = b"", np.zeros((0, 3))
        self._parts = [(name, slice(6 * i, 6 * i + 6)) for i, name in enumerate(terms.sets)]
        self._n = 6 * len(terms.sets)
        self._shown: dict[str, Array] = {}
        self._shown_points = self._given_points
        self.last: tuple[Array, Array] = np.zeros(0), self._given_points
        self._choice: CompiledChoice | None = None
        self._candidates: Candidates | None = None

    @classmethod
    def of(cls, terms: Terms, cost: Cost) -> Self | None:
        """None where the general road is needed for every program."""
        allocation = CompiledAllocation.of(terms.template, cost)
        return None if allocation is None else cls(terms, allocation)

    def renewed(self) -> Self | None:
        """The planning for `terms` whose arms are new, in the same workspace; None where they need another."""
        if not self._allocation.fits(self._terms.template):
            return None
        return self if self._own is self._terms.candidates else type(self)(self._terms, self._allocation)

    def at(self, contacts: Mapping[str, ArrayLike] | None, wrench: Point, cost: Cost, start: float) -> Plan | None:
        """The optimal plan at given contacts, or where arms have no choice."""
        points = self._own_points if contacts is None else self._points(contacts)
        self._allocation.is_infeasible = False
        if points is None:
            return None
        self._allocation.take(self._terms.template, cost)
        if not self._allocation.solve(wrench, points):
            return None
        return self._plan(points, wrench, None, start)

    @property
    def is_infeasible(self) -> bool:
        """Whether what `at` was asked for last is proven to be."""
        return self._allocation.is_infeasible

    def choose(
        self, candidates: Candidates, wrench: Point, cost: Cost, limit: SearchLimit, switching: Switching | None
    ) -> Choice | None:
        """The search's result; `chosen` is its plan where there are contacts. None if it is for the general search."""
        if candidates is not self._candidates:
            self._candidates, self._choice = candidates, CompiledChoice.of(candidates, self._allocation)
        if self._choice is None:
            return None
        self._allocation.take(self._terms.template, cost)
        choice = self._choice.run(wrench, cost, limit, switching)
        if choice is None or choice.bound > -math.inf:
            return choice
        return replace(choice, bound=min(choice.value, least_cost(self._terms.template, cost)))

    def chosen(self, choice: Choice, wrench: Point, start: float) -> Plan:
        assert choice.contacts is not None
        return self._plan(choice.contacts, wrench, choice.proof, start)

    def forget(self) -> None:
        """The next search begins as if it were the first."""
        self._candidates = None

    # --- contacts -----------------------------------------------------------------------------------------

    def _points(self, contacts: Mapping[str, ArrayLike]) -> Array | None:
        """Contacts of all arms (n, 3), the same object as long as they are the same."""
        try:
            points = real_numbers([contacts[name] for name in self._terms.sets])
            if points is None or len(contacts) > len(self._parts):
                return None
        except (KeyError, IndexError, TypeError):
            return None
        given = points.tobytes()
        if given != self._given:
            if points.shape != (len(self._parts), 3) or self._is_refused(points):
                return None
            points.setflags(write=False)
            self._given, self._given_points = given, points
        return self._given_points

    def _is_refused(self, points: Array) -> bool:
        """Whether hands are too near, or out of reach; what is no position without either, the kernel refuses."""
        distance, reaching = self._own.distance, self._reaching
        if not (distance > 0 or reaching):
            return False
        if not (np.abs(points) <= LARGEST_POSITION).all():
            return True
        if distance > 0:
            pairs = combinations(points.tolist(), 2)
            if min((math.dist(p, q) for p, q in pairs), default=math.inf) < distance - DISTANCE_TOLERANCE:
                return True
        at = dict(zip(self._terms.sets, points, strict=True))
        return any(float(reach.excess(at[name])) > REACH_TOLERANCE for name, reach in reaching)

    # --- answers ------------------------------------------------------------------------------------------

    def _plan(self, points: Array, wrench: Point, choice: ChoiceProof | None, start: float) -> Plan:
        """The plan from what the compiled allocation holds."""
        found = self._allocation
        answer = found.answer()
        answer.setflags(write=False)  # plans show it
        self.last = answer[: self._n], points
        if points is not self._shown_points:
            self._shown_points = points
            self._shown = {name: points[i] for i, name in enumerate(self._terms.sets)}
        fields = {
            "status": OPTIMAL,
            "wrenches": {name: answer[part] for name, part in self._parts},
            "contacts": self._shown.copy(),
            "yaws": self._terms.yaws,
            "solve_time": time.perf_counter() - start,
            "solver": SOLVER,
            "message": "",
            "tell": partial(_told, self._terms.template, answer, found.names, choice),
            "wheel_forces": self._terms.wheel_forces,
            "arms": self._terms.base.arms,
            "prove": partial(_proof, self._terms.template, (points, wrench, found.cost), answer),
        }
        return Plan.of(fields)


def _told(template: AllocationTemplate, answer: Array, names: LimitNames, choice: ChoiceProof | None) -> Figures:
    wrenches, multipliers = answer[: template.n], answer[template.n : -N_RESIDUALS]
    residuals = Residuals._make(answer[-N_RESIDUALS:].tolist())
    proof = choice or ChoiceProof(residuals.cost, 0.0, 1)
    return Figures(template.effort(wrenches), active_limits(multipliers, names), residuals, proof)


def _proof(
    template: AllocationTemplate, asked: tuple[Array, Point, Cost], answer: Array
) -> tuple[QuadraticProgram, QPSolution]:
    """The program that was solved, built the general way, with its solution checked in numpy."""
    points, wrench, cost = asked
    program = template.program(template.contact_rows(points), template.basis_b.T @ np.array(wrench), cost)
    x, y = answer[: template.n], answer[template.n : -N_RESIDUALS]
    return program, QPSolution.checked(program, x, y, (), SOLVER)
