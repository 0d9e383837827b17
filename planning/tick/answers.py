"""Solved programs as plans: optimal, relaxed, or infeasible with a certificate."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array

from ..allocation.allocation import Allocation, conclude
from ..allocation.second_stage import second_stage
from ..contacts.contact_choice import Choice
from ..objectives import Lexicographic
from ..plan import RELAXED, ChoiceProof, Figures, Plan
from ..quadratic_program import OPTIMAL, QPSolution, QuadraticProgram
from ..solvers import QuadraticSolver
from .terms import Terms


class Solved(NamedTuple):
    """A program at contacts (n, 3) with what a solver says of it, and since when it was worked on (perf_counter)."""

    points: Array
    program: QuadraticProgram
    solution: QPSolution
    start: float


class Answers:
    """Makes plans for terms; `relax` is how far a relaxed plan may be from what is asked, `solver` a name of one."""

    def __init__(self, terms: Terms, relax: float, solver: str | None = None) -> None:
        self._terms, self._relax = terms, relax
        self._second_solver = QuadraticSolver(name=solver)
        self._shown: dict[str, Array] = {}
        self._shown_points = np.zeros((0, 3))

    def of(self, solved: Solved, last: Array, proof: ChoiceProof | None = None) -> Plan:
        """`last` are the wrenches (6n,) before, `proof` is that of the contacts where these were chosen."""
        if solved.solution.status == OPTIMAL:
            return self._optimal(solved, last, proof)
        allocation = conclude(self._terms.template, solved.points, solved.program, solved.solution)
        if allocation.status == OPTIMAL:
            return self._optimal(solved._replace(solution=allocation.solution), last, proof)
        relaxed = self._relaxed(solved, allocation, last, proof)
        if relaxed is not None:
            return relaxed
        words = f"no solver gave an answer that verifies ({allocation.solution.message})"
        words = allocation.certificate.words if allocation.certificate else words
        return Plan(
            status=allocation.status,
            tell=partial(Figures, choice=proof),
            certificate=allocation.certificate,
            solve_time=time.perf_counter() - solved.start,
            solver=allocation.solution.solver,
            message=words,
        )

    def by_arm(self, values: Array) -> dict[str, Array]:
        """Rows of values (n, k) or (n k,) by the arms' names."""
        return dict(zip(self._terms.base.names, values.reshape(len(self._terms.sets), -1), strict=True))

    def _optimal(self, solved: Solved, last: Array, proof: ChoiceProof | None) -> Plan:
        program, solution, base = solved.program, solved.solution, self._terms.base
        proof = proof or ChoiceProof(solution.cost, 0.0, 1)
        if isinstance(base.objective, Lexicographic):
            second = base.second_cost(last, self._terms.straight)
            program, solution = second_stage(self._second_solver, program, solution, second)
        wrenches = solution.x if len(solution.x) == base.n else solution.x[: base.n]
        wrenches.setflags(write=False)  # plans show them
        return Plan(
            status=OPTIMAL,
            wrenches=self.by_arm(wrenches),
            contacts=self._contacts_at(solved.points),
            yaws=self._terms.yaws,
            solve_time=time.perf_counter() - solved.start,
            solver=solution.solver,
            message=solution.message,
            tell=lambda: Figures(base.effort(wrenches), program.active(solution), solution.residuals, proof),
            prove=lambda: (program, solution),
            wheel_forces=self._terms.wheel_forces,
            beside=self._terms.beside,
            arms=base.arms,
        )

    def _relaxed(self, solved: Solved, allocation: Allocation, last: Array, proof: ChoiceProof | None) -> Plan | None:
        """The nearest wrench that can be given, where it is near enough."""
        certificate = allocation.certificate
        nearest = None if certificate is None else certificate.nearest
        if certificate is None or nearest is None or not nearest.may_stand_in(self._relax):
            return None
        plan = self._optimal(solved._replace(program=nearest.program, solution=nearest.solution), last, proof)
        active = tuple(dict.fromkeys((*certificate.limits, *plan.active)))
        figures = plan.figures._replace(active=active)
        words = certificate.words
        return replace(plan, status=RELAXED, tell=lambda: figures, certificate=certificate, message=words)

    def _contacts_at(self, points: Array) -> dict[str, Array]:
        if points is not self._shown_points:
            points.setflags(write=False)
            self._shown_points, self._shown = points, self.by_arm(points)
        return self._shown.copy()


def proof_of(choice: Choice, solution: QPSolution) -> ChoiceProof:
    """The proof for the contacts that were chosen; `solution` is that of the plan's own program, solved once more."""
    cost = solution.cost + choice.switching if solution.status == OPTIMAL else choice.value
    gap = max(0.0, cost - choice.bound) / max(1.0, abs(cost)) if np.isfinite(choice.bound) else np.inf
    return ChoiceProof(choice.bound, gap, choice.solved + 1, choice.switching)
