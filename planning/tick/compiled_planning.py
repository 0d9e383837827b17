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

from cartgrasp.contacts import MAX_POSITION, grasp_map_spatial
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
from .compiled_nearest import UNPROVEN, Bend, Near, Nearest, nearest
from .given_contacts import REACH_TOLERANCE
from .plan_inputs import real_numbers
from .tangents import Tangents, in_sum, values_of
from .terms import Terms

N_RESIDUALS = len(Residuals._fields)
MAX_TANGENT_UPDATES = 12
"""Most programs in which half-spaces are turned until the cones hold."""


# Many methods: what compiled planning does at given and at chosen contacts, in one workspace that nobody else writes.
class CompiledPlanning:
    """Plans for the candidates of `terms`; others need a new one. `last` are the wrenches (6n,) and contacts of the
    last plan."""

    def __init__(self, terms: Terms, allocation: CompiledAllocation) -> None:
        self._terms, self._allocation, self._own = terms, allocation, terms.candidates
        self._reaching = terms.reaching(terms.sets)
        own = self._own.single
        self._own_points = None if own is None or self._is_refused(own) else own
        self._given, self._given_points = b"", np.zeros((0, 3))
        self._asked_at = self._given_points
        self._parts = [(name, slice(6 * i, 6 * i + 6)) for i, name in enumerate(terms.sets)]
        self._n = 6 * len(terms.sets)
        self._shown: dict[str, Array] = {}
        self._shown_points = self._given_points
        self.last: tuple[Array, Array] = np.zeros(0), self._given_points
        self._choice: CompiledChoice | None = None
        self._candidates: Candidates | None = None
        self._tangents: Tangents | None = None
        self._bend: Bend | None = None
        self._linear: AllocationTemplate | None = None
        self._mapped = (self._given_points, np.zeros(0), np.zeros((0, 6, 6)))

    @classmethod
    def of(cls, terms: Terms, cost: Cost) -> Self | None:
        """None where the general road is needed for every program."""
        allocation = CompiledAllocation.of(_without_cones(terms.template), cost)
        return None if allocation is None else cls(terms, allocation)

    def renewed(self) -> Self | None:
        """The planning for `terms` whose arms are new, in the same workspace; None where they need another."""
        if not self._allocation.fits(_without_cones(self._terms.template)):
            return None
        return self if self._own is self._terms.candidates else type(self)(self._terms, self._allocation)

    def at(self, contacts: Mapping[str, ArrayLike] | None, wrench: Point, cost: Cost, start: float) -> Plan | None:
        """The optimal plan at given contacts, or where arms have no choice."""
        points = self._own_points if contacts is None else self._points(contacts)
        self._allocation.is_infeasible = False
        if points is None:
            return None
        self._asked_at = points
        last = self.last[0] if len(self.last[0]) else np.zeros(self._n)
        self._tangents = None if not self._terms.template.cart_rows.cone_names else self._touching(points, last)
        return self._plan(points, wrench, None, start) if self._solves(wrench, points, cost) else None

    def nearest(self, wrench: Point, cost: Cost, start: float) -> Near:
        """The plan of the nearest, where `at` found that a wrench can't be given, and how far it is."""
        points, basis_b = self._asked_at, self._terms.template.basis_b
        if self._tangents is not None and self._bend is not None:  # goes on from what was nearest before
            self._tangents = self._touching(points, self._bend.about)
        for _ in range(MAX_TANGENT_UPDATES):
            found = nearest(self._posed(), points, wrench, None if self._tangents is None else self._bend)
            if isinstance(found, str):
                return found
            missing = found.missing
            turned = self._turned(points, wrench, found.wrenches)
            if turned is None:
                x, y, turn = (wrench - basis_b @ np.linalg.solve(basis_b.T @ basis_b, missing)).tolist()
                if not self._solves((x, y, turn), points, cost):
                    return UNPROVEN
                return self._plan(points, (x, y, turn), None, start), float(np.linalg.norm(missing))
            self._tangents, self._bend = turned, self._bent(turned, found)
        self._bend = None
        return UNPROVEN

    def _bent(self, tangents: Tangents, found: Nearest) -> Bend:
        """How cones bend at wrenches that were found, so that the next are those of Newton's method."""
        maps = self._maps(self._asked_at)
        whole = in_sum(maps)
        bent = tangents.curvature(values_of(tangents.rows, found.wrenches, maps), found.of_cart_rows)
        return Bend(whole.T @ bent @ whole, found.wrenches)

    def _solves(self, wrench: Point, points: Array, cost: Cost) -> bool:
        """Whether the allocation then has the proven optimum, at which the cones hold."""
        for _ in range(MAX_TANGENT_UPDATES):
            self._allocation.take(self._posed(), cost)
            if not self._allocation.solve(wrench, points):
                return False
            turned = self._turned(points, wrench)
            if turned is None:
                return True
            self._tangents = turned
        return False

    def _touching(self, points: Array, wrenches: Array) -> Tangents:
        """Half-spaces for the cones of now, which touch them at wrenches (6n,)."""
        rows = self._terms.template.cart_rows
        return Tangents.touching(rows, values_of(rows, wrenches, self._maps(points)))

    def _turned(self, points: Array, wrench: Point, found: Array | None = None) -> Tangents | None:
        """Half-spaces for another try, where a cone doesn't hold at the wrenches (6n,) that were found: the
        allocation's, unless others are given."""
        if self._tangents is None:
            return None
        found = self._allocation.answer()[: self._n] if found is None else found
        values = values_of(self._tangents.rows, found, self._maps(points))
        return self._tangents.turned(values, max(1.0, *map(abs, wrench)))

    def _maps(self, points: Array) -> Array:
        """Spatial grasp maps (n, 6, 6) at points (n, 3), the same object as long as these are."""
        yaws = self._terms.template.yaws
        if points is not self._mapped[0] or yaws is not self._mapped[1]:
            self._mapped = points, yaws, grasp_map_spatial(points, yaws)
        return self._mapped[2]

    def _posed(self) -> AllocationTemplate:
        """The terms' template with half-spaces in the place of cones. It goes on from the last such one, whose cached
        values it keeps."""
        template, before = self._terms.template, self._linear
        if self._tangents is None:
            return template
        if before is None or before.arms is not template.arms or before.limits is not template.limits:
            before = template
        self._linear = before.with_cart_rows(self._tangents.linear)
        return self._linear

    @property
    def is_infeasible(self) -> bool:
        """Whether what `at` was asked for last is proven to be."""
        return self._allocation.is_infeasible

    def choose(
        self, candidates: Candidates, wrench: Point, cost: Cost, limit: SearchLimit, switching: Switching | None
    ) -> Choice | None:
        """The search's result; `chosen` is its plan where there are contacts. None if it is for the general search."""
        if self._terms.template.cart_rows.cone_names:
            return None
        self._tangents = None
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
        self._candidates = self._bend = None

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
        if not (np.abs(points) <= MAX_POSITION).all():
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
            "beside": self._terms.beside,
            "arms": self._terms.base.arms,
            "prove": partial(_proof, self._terms.template, (points, wrench, found.cost), answer, self._tangents),
        }
        return Plan.of(fields)


def _told(template: AllocationTemplate, answer: Array, names: LimitNames, choice: ChoiceProof | None) -> Figures:
    wrenches, multipliers = answer[: template.n], answer[template.n : -N_RESIDUALS]
    residuals = Residuals._make(answer[-N_RESIDUALS:].tolist())
    proof = choice or ChoiceProof(residuals.cost, 0.0, 1)
    return Figures(template.effort(wrenches), active_limits(multipliers, names), residuals, proof)


def _proof(
    template: AllocationTemplate, asked: tuple[Array, Point, Cost], answer: Array, tangents: Tangents | None
) -> tuple[QuadraticProgram, QPSolution]:
    """The program that was solved, built the general way, with its solution checked in numpy."""
    points, wrench, cost = asked
    program = template.program(template.contact_rows(points), template.basis_b.T @ np.array(wrench), cost)
    x, y = answer[: template.n], answer[template.n : -N_RESIDUALS]
    if tangents is None:
        return program, QPSolution.checked(program, x, y, (), SOLVER)
    first, k = template.n + len(template.fixed.limits), template.basis_b.shape[1]
    of_rows, of_cones = tangents.multipliers(y[first:-k])
    y = np.concatenate([y[:first], of_rows, y[-k:]])
    return program, QPSolution.checked(program, x, y, of_cones, SOLVER)


def _without_cones(template: AllocationTemplate) -> AllocationTemplate:
    """The template with a half-space for each of the cart's cones."""
    rows = template.cart_rows
    if not rows.cone_names:
        return template
    return template.with_cart_rows(Tangents.touching(rows, np.zeros(len(rows.low))).linear)
