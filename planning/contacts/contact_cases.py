"""One solved case of contact choice: a pair of vertices (high, low), equal where the contacts are points.

Two questions are asked of cases, and answered in the same form: the least effort, or (when nothing is feasible) the
least ½ distance² to what is asked. Each answer comes with a cut that bounds it over all other contacts (duality.py).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from cartgrasp.frames import Array

from ..allocation.allocation_template import AllocationTemplate
from ..allocation.contradiction import contradiction
from ..allocation.duality import Cut, distance_cut, effort_cut, farkas_cut, infeasible_by, least_cost, of_cart
from ..allocation.projection import Projection, project
from ..objectives import Cost
from ..quadratic_program import OPTIMAL, QPSolution, QuadraticProgram
from ..solvers import QuadraticSolver, solve_with_clarabel
from .switching_cost import Switching

GAP_TOLERANCE = 1e-9


@dataclass(frozen=True, eq=False)
class Answer:
    """`value` is infinite where infeasible, else `wrenches` (6n,) reach the effective wrench `reached` (k,);
    `proven` is False where no solver gave a verified answer."""

    value: float
    cut: Cut | None = None
    wrenches: Array = field(default_factory=lambda: np.zeros(0))
    reached: Array = field(default_factory=lambda: np.zeros(0))
    proven: bool = True


@dataclass(frozen=True, eq=False)
class Question:
    """What is asked of every case: an effective wrench (k,) at a cost, or the distance to it. Only the first is charged
    for `switching`."""

    target: Array
    cost: Cost
    distance: bool = False
    switching: Switching | None = None

    @property
    def seed(self) -> Array | None:
        """Contacts to begin with: where all arms stay, if they can."""
        return None if self.switching is None else self.switching.seed

    def charge(self, low: Array, high: Array) -> float:
        """Beside the effort, of contacts between two corners (n, 3)."""
        return 0.0 if self.switching is None or self.distance else self.switching.at(low, high)

    def least(self, template: AllocationTemplate) -> float:
        """What no contacts are below, before any are tried."""
        return 0.0 if self.distance else least_cost(template, self.cost)

    def tolerance(self, value: float, gap: float) -> float:
        """How near to a value a bound has to come: a relative gap, of at least 1 for an effort."""
        if self.distance:
            return gap * value + 1e-18 * (1.0 + float(self.target @ self.target))
        return gap * max(1.0, abs(value))


class CaseSolver:
    """Warm solvers for point cases and range cases, each for efforts and for distances."""

    def __init__(self, template: AllocationTemplate, solver: str | None = None) -> None:
        self.template = template
        self.solved = 0
        self._effort = {is_range: QuadraticSolver(name=solver) for is_range in (False, True)}
        self._distance = {is_range: QuadraticSolver(always_feasible=True) for is_range in (False, True)}

    def answer(self, question: Question, high: Array, low: Array, hull: Array | None = None) -> Answer:
        """Contacts (n, 3) at the high and the low vertex of those that span the case, `hull` (v, n, 3); without a
        hull, or with one of one, contacts are points."""
        template, self.solved = self.template, self.solved + 1
        rows = template.contact_rows(high)
        is_range = hull is not None and len(hull) > 1
        if hull is not None and is_range:
            pair = rows, template.contact_rows(low)
            spanned = template.contact_rows(hull) if len(template.cart_rows.low) else hull
            program = template.range_program(pair, spanned, question.target, question.cost)
        else:
            program = template.program(rows, question.target, question.cost)
        if question.distance:
            return self._distance_answer(question, program, is_range)
        return self._effort_answer(question, program, is_range)

    def _effort_answer(self, question: Question, program: QuadraticProgram, is_range: bool) -> Answer:
        solution = self._effort[is_range].solve(program)
        if solution.status == OPTIMAL:
            return self._solved(question, solution, is_range)
        projection = self._project(program, is_range)
        if projection.solution.status == OPTIMAL and not projection.is_feasible(question.target):
            normal = projection.normal, projection.normal_solution
            if infeasible_by(program, normal[1], normal[0]) > 0:
                return Answer(np.inf, farkas_cut(self.template, normal[1], normal[0], question.target))
        solution = solve_with_clarabel(program)
        if solution.status == OPTIMAL:
            return self._solved(question, solution, is_range)
        return self._contradicted(question, program, is_range)

    def _distance_answer(self, question: Question, program: QuadraticProgram, is_range: bool) -> Answer:
        projection = self._project(program, is_range)
        if projection.solution.status != OPTIMAL:
            return self._contradicted(question, program, is_range)
        cut = distance_cut(self.template, projection.solution, projection.slack, question.target)
        return Answer(
            0.5 * projection.distance**2,
            cut,
            projection.wrenches[: self.template.n],
            question.target - projection.slack,
        )

    def _contradicted(self, question: Question, program: QuadraticProgram, is_range: bool) -> Answer:
        """No answer: proven where the cart's limits can't be kept at all."""
        return Answer(np.inf, proven=contradiction(self.template, program, question.target, is_range) is not None)

    def _solved(self, question: Question, solution: QPSolution, is_range: bool) -> Answer:
        template = self.template
        of_limits = of_cart(template, solution)
        effective = solution.multipliers[len(solution.x) + len(template.fixed.limits) + len(of_limits) :]
        dual = np.concatenate([of_limits, effective])
        multipliers = np.concatenate([of_limits, dual @ template.slack_map(is_range)])
        cut = effort_cut(template, solution, multipliers, question.target, question.cost)
        return Answer(solution.cost, cut, solution.x[: template.n], question.target)

    def _project(self, program: QuadraticProgram, is_range: bool) -> Projection:
        return project(self._distance[is_range], program, self.template.slack_map(is_range))
