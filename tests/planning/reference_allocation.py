"""The independent reference: the same program in cvxpy, as planners give it to their users, and solved by Clarabel to
tight tolerances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from planning.quadratic_program import QuadraticProgram
from planning.solvers.cvxpy_problem import pose

TOLERANCE = 1e-11


@dataclass(frozen=True, eq=False)
class ReferenceSolution:
    """cvxpy's status (`optimal`, `infeasible`, …), the unknowns (n,) and the cost; NaN unless optimal."""

    status: str
    x: Array
    cost: float


def solve_reference(program: QuadraticProgram) -> ReferenceSolution:
    posed, tight = pose(program), dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), TOLERANCE)
    posed.problem.solve(solver="CLARABEL", **tight)
    if posed.problem.status not in ("optimal", "optimal_inaccurate"):
        return ReferenceSolution(str(posed.problem.status), np.full(program.n, np.nan), np.nan)
    return ReferenceSolution(str(posed.problem.status), np.asarray(posed.x.value), float(posed.problem.value))
