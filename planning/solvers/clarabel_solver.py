"""Clarabel, an interior-point conic solver: for second-order cones, and where daqp fails."""

from __future__ import annotations

from dataclasses import replace

import clarabel
import numpy as np
from scipy import sparse

from planning.quadratic_program import INFEASIBLE, NUMERICAL, OPTIMAL, QPSolution, QuadraticProgram

from .one_sided import OneSided
from .polish import polish

CLARABEL_TOLERANCE = 1e-12
PROXIMAL_STEPS = 5
PROXIMAL_WEIGHT_RATIO = 1e-4  # of the largest curvature, at least 1
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


def solve_by_steps(program: QuadraticProgram, solution: QPSolution) -> QPSolution:
    """From what a solver came to, by proximal points (Rockafellar 1976), for costs that are flat along some directions,
    where an interior point stalls; that again where no step ends in an answer that verifies.

    Each step minimises the cost and a little of the squared way from the last point, which is strictly convex. Where a
    step leads nowhere, its multipliers are those of the cost alone."""
    x = solution.x
    added = PROXIMAL_WEIGHT_RATIO * max(1.0, float(np.abs(program.hessian).max(initial=0.0)))
    for _ in range(PROXIMAL_STEPS):
        curved = program.hessian + added * np.eye(program.n)
        step = solve(replace(program, hessian=curved, gradient=program.gradient - added * x))
        if not np.isfinite(step.residuals.equality):
            return solution
        found = QPSolution.checked(
            program, step.x, step.multipliers, step.cone_multipliers, "clarabel, in steps", solution.message
        )
        found = found if found.status == OPTIMAL else polish(program, found)
        if found.status == OPTIMAL:
            return found
        x = step.x
    return solution


def _settings() -> clarabel.DefaultSettings:
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = CLARABEL_TOLERANCE
    settings.tol_ktratio = 1e-10
    return settings
