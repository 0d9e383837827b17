"""Clarabel, an interior-point conic solver: for second-order cones, and where daqp fails."""

from __future__ import annotations

import clarabel
import numpy as np
from scipy import sparse

from planning.quadratic_program import INFEASIBLE, NUMERICAL, QPSolution, QuadraticProgram

TOLERANCE = 1e-12
DIVERGED = 1e50  # what is larger overflows in a proof
USABLE = ("Solved", "AlmostSolved", "InsufficientProgress", "MaxIterations")


def solve(program: QuadraticProgram) -> QPSolution:
    """Clarabel's form: minimise ½ xᵀPx + qᵀx with A x + s = b and s in a product of cones; z are its
    multipliers."""
    everything = np.vstack([np.eye(program.n), program.rows])
    equal = program.sense | (program.lower == program.upper)
    up = np.flatnonzero(~equal & (program.upper < np.inf))
    low = np.flatnonzero(~equal & (program.lower > -np.inf))
    blocks = [everything[equal], everything[up], -everything[low], *(-cone.rows for cone in program.cones)]
    values = [
        program.upper[equal],
        program.upper[up],
        -program.lower[low],
        *(c.offset for c in program.cones),
    ]
    cones = [clarabel.ZeroConeT(int(equal.sum())), clarabel.NonnegativeConeT(len(up) + len(low))]
    cones += [clarabel.SecondOrderConeT(len(cone.offset)) for cone in program.cones]
    hessian = sparse.csc_matrix(np.triu(program.hessian))
    matrix = sparse.csc_matrix(np.vstack(blocks))
    found = clarabel.DefaultSolver(
        hessian, program.gradient, matrix, np.concatenate(values), cones, _settings()
    ).solve()
    status = str(found.status)
    if status not in USABLE:
        claimed = INFEASIBLE if "PrimalInfeasible" in status else NUMERICAL
        return QPSolution.failed(program, claimed, "clarabel", f"Clarabel ended with {status}")
    x = np.asarray(found.x)
    if not max(np.abs(x).max(initial=0.0), np.abs(found.z).max(initial=0.0)) <= DIVERGED:
        return QPSolution.failed(program, NUMERICAL, "clarabel", "Clarabel diverged")
    parts = np.split(np.asarray(found.z), np.cumsum([len(v) for v in values])[:-1])
    y = np.zeros(len(program.upper))
    y[equal] = parts[0]
    y[up] += np.maximum(parts[1], 0.0)
    y[low] -= np.maximum(parts[2], 0.0)
    return QPSolution.checked(program, x, y, parts[3:], "clarabel", status)


def _settings() -> clarabel.DefaultSettings:
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = TOLERANCE
    settings.tol_ktratio = 1e-10
    return settings
