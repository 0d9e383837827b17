"""Clarabel, an interior-point conic solver: for second-order cones, and where daqp fails."""

from __future__ import annotations

import clarabel
import numpy as np
from scipy import sparse

from planning.quadratic_program import INFEASIBLE, NUMERICAL, QPSolution, QuadraticProgram

from .one_sided import OneSided

CLARABEL_TOLERANCE = 1e-12
MAX_SOLUTION = 1e50  # what is larger overflows in a proof
USABLE_STATUSES = ("Solved", "AlmostSolved", "InsufficientProgress", "MaxIterations")


def solve(program: QuadraticProgram) -> QPSolution:
    """Clarabel's form: minimise ½ xᵀPx + qᵀx with A x + s = b and s in a product of cones; z are its
    multipliers."""
    sides, cones = OneSided.of(program), program.cones
    kinds = [clarabel.ZeroConeT(len(sides.b)), clarabel.NonnegativeConeT(len(sides.h))]
    kinds += [clarabel.SecondOrderConeT(len(cone.offset)) for cone in cones]
    matrix = sparse.csc_matrix(np.vstack([sides.A, sides.G, *(-cone.rows for cone in cones)]))
    values = [sides.b, sides.h, *(cone.offset for cone in cones)]
    hessian = sparse.csc_matrix(np.triu(program.hessian))
    found = clarabel.DefaultSolver(
        hessian, program.gradient, matrix, np.concatenate(values), kinds, _settings()
    ).solve()
    status = str(found.status)
    if status not in USABLE_STATUSES:
        claimed = INFEASIBLE if "PrimalInfeasible" in status else NUMERICAL
        return QPSolution.failed(program, claimed, "clarabel", f"Clarabel ended with {status}")
    x = np.asarray(found.x)
    if not max(np.abs(x).max(initial=0.0), np.abs(found.z).max(initial=0.0)) <= MAX_SOLUTION:
        return QPSolution.failed(program, NUMERICAL, "clarabel", "Clarabel diverged")
    of_equal, of_rest, *z = np.split(np.asarray(found.z), np.cumsum([len(v) for v in values])[:-1])
    y = sides.multipliers(of_equal, of_rest, len(program.upper))
    return QPSolution.checked(program, x, y, z, "clarabel", status)


def _settings() -> clarabel.DefaultSettings:
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = CLARABEL_TOLERANCE
    settings.tol_ktratio = 1e-10
    return settings
