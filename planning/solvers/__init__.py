"""The only rooms that know a solver: daqp or the one asked for by name first, Clarabel where that can't or doesn't, a
polish in between."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from planning.quadratic_program import INFEASIBLE, OPTIMAL, QPSolution, QuadraticProgram

from .daqp_solver import DaqpSolver
from .polish import polish

if TYPE_CHECKING:
    from .named_solver import NamedSolver

__all__ = ["QuadraticSolver", "solve_with_clarabel"]


class QuadraticSolver:
    """Solves programs of one structure, warm; what it returns as `optimal` has been verified.

    `always_feasible` is for projections: they have a solution, whatever daqp says, and a Hessian without full
    rank, where daqp iterates; so each is polished even within tolerance. So is what the solver finds that is asked by
    `name` in the place of daqp; its word that there is no answer counts for nothing.
    """

    def __init__(self, always_feasible: bool = False, name: str | None = None) -> None:
        self._first: DaqpSolver | NamedSolver
        if name is None:
            self._first = DaqpSolver()
        else:
            from .named_solver import NamedSolver  # imports qpsolvers

            self._first = NamedSolver(name)
        self._always_polished, self._is_named = always_feasible or name is not None, name is not None

    def solve(self, program: QuadraticProgram) -> QPSolution:
        if program.cones and not self._is_named:
            return solve_with_clarabel(program)
        solution = self._first.solve(program)
        if solution.status in (OPTIMAL, INFEASIBLE) and not self._always_polished:
            return solution
        if np.isfinite(solution.residuals.equality):
            polished = polish(program, solution)
            if polished.status == OPTIMAL:
                return polished
        if solution.status == OPTIMAL:
            return solution
        fallback = solve_with_clarabel(program)
        why = solution.message or f"{solution.solver} did not reach the tolerance"
        return replace(fallback, message=f"fallback: {why}")


def solve_with_clarabel(program: QuadraticProgram) -> QPSolution:
    """Interior point, then a polish on the active set it found, or steps; about 100 times slower than daqp."""
    from .clarabel_solver import solve, solve_by_steps

    solution = solve(program)
    if not np.isfinite(solution.residuals.equality):
        return solution
    polished = polish(program, solution)
    if polished.status == OPTIMAL:
        return polished
    return solution if solution.status == OPTIMAL else solve_by_steps(program, solution)
