"""Proximal points (Rockafellar 1976), for costs that are flat along some directions, where an interior point stalls.

Each step minimises the cost and a little of the squared way from the last point, which is strictly convex. Where a step
leads nowhere, its multipliers are those of the cost alone.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planning.quadratic_program import OPTIMAL, QPSolution, QuadraticProgram

from .clarabel_solver import solve
from .polish import polish

PROXIMAL_STEPS = 5
PROXIMAL_WEIGHT_RATIO = 1e-4  # of the largest curvature, at least 1


def solve_by_steps(program: QuadraticProgram, solution: QPSolution) -> QPSolution:
    """From what a solver came to; that again where no step ends in an answer that verifies."""
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
