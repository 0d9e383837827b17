"""The only rooms that know a solver: daqp first, Clarabel where daqp can't or doesn't, a polish in
between."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planning.quadratic_program import INFEASIBLE, OPTIMAL, QPSolution, QuadraticProgram

from .daqp_solver import DaqpSolver
from .polish import polish

__all__ = ["QuadraticSolver", "solve_with_clarabel"]


class QuadraticSolver:
    """Solves programs of one structure, warm; what it returns as `optimal` has been verified.

    `always_feasible` is for projections: they have a solution, whatever daqp says, and a Hessian without full
    rank, where daqp iterates; so each is polished even within tolerance.
    """

    def __init__(self, always_feasible: bool = False) -> None:
        self._daqp = DaqpSolver()
        self._always_feasible = always_feasible

    def solve(self, program: QuadraticProgram) -> QPSolution:
        if program.cones:
            return solve_with_clarabel(program)
        solution = self._daqp.solve(program)
        if solution.status in (OPTIMAL, INFEASIBLE) and not self._always_feasible:
            return solution
        if np.isfinite(solution.residuals.equality):
            polished = polish(program, solution)
            if polished.status == OPTIMAL:
                return polished
        if solution.status == OPTIMAL:
            return solution
        fallback = solve_with_clarabel(program)
        return replace(fallback, message=f"fallback: {solution.message or 'daqp did not reach the tolerance'}")


def solve_with_clarabel(program: QuadraticProgram) -> QPSolution:
    """Interior point, then a polish on the active set it found, or steps; about 100 times slower than daqp."""
    from .clarabel_solver import solve
    from .proximal import solve_by_steps

    solution = solve(program)
    if not np.isfinite(solution.residuals.equality):
        return solution
    polished = polish(program, solution)
    if polished.status == OPTIMAL:
        return polished
    return solution if solution.status == OPTIMAL else solve_by_steps(program, solution)
