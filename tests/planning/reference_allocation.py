"""The independent reference: the same program posed in cvxpy and solved by Clarabel to tight tolerances.

It shares with the fast path only the arrays of the `QuadraticProgram`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from planning.quadratic_program import QuadraticProgram

TOLERANCE = 1e-11


@dataclass(frozen=True, eq=False)
class ReferenceSolution:
    """cvxpy's status (`optimal`, `infeasible`, …), the unknowns (n,) and the cost; NaN unless optimal."""

    status: str
    x: Array
    cost: float


def solve_reference(program: QuadraticProgram) -> ReferenceSolution:
    import cvxpy

    x = cvxpy.Variable(program.n)
    cost = 0.5 * cvxpy.quad_form(x, cvxpy.psd_wrap(program.hessian)) + program.gradient @ x + program.constant
    matrix, value = program.equality
    rows, low, high = program.inequality
    lower, upper = program.bounds
    constraints = [matrix @ x == value] if len(value) else []
    for values, below, above in ((x, lower, upper), (rows @ x if len(rows) else None, low, high)):
        for limit, sign in ((above, 1.0), (below, -1.0)):
            held = np.flatnonzero(np.isfinite(limit))
            if values is not None and len(held):
                constraints.append(sign * values[held] <= sign * limit[held])
    for cone in program.cones:
        s = cone.offset + cone.rows @ x
        constraints.append(cvxpy.SOC(s[0], s[1:]))
    problem = cvxpy.Problem(cvxpy.Minimize(cost), constraints)
    tolerances = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), TOLERANCE)
    problem.solve(solver=cvxpy.CLARABEL, **tolerances)
    if problem.status not in ("optimal", "optimal_inaccurate"):
        return ReferenceSolution(str(problem.status), np.full(program.n, np.nan), np.nan)
    return ReferenceSolution(str(problem.status), np.asarray(x.value), float(problem.value))
