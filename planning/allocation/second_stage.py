"""The second objective of a lexicographic order, over all that are best by the first.

The minimisers of a convex quadratic cost ½ xᵀ H x + fᵀ x over a convex set are those of its points with the same
H x and fᵀ x: so the second program has these as rows, held at the first's solution, and is a QP as well.

Rows have a little room, which active-set methods need. An interior-point method finds next to no interior there, so
where it ends without an answer that verifies, they are held exactly: then they are equalities to it.

A proof takes rows for kept that are broken by a share of the wrench asked for, which is in newtons. Rows that state a
cost, the first's own among them, are in its unit: they are written as many times larger as the wrench is above 1, so a
share of the wrench is the same share of them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cartgrasp.frames import Array

from ..objectives import Cost
from ..quadratic_program import OPTIMAL, QPSolution, QuadraticProgram
from ..solvers import QuadraticSolver, solve_with_clarabel

FIRST_STAGE_TOLERANCE = 1e-9  # how near to the first's solution its rows are held, of their largest
LEFT_OPEN = "the second objective is left open: no solver gave an answer for it that verifies"
CURVATURE_RANK_TOLERANCE = 1e-9  # of the largest eigenvalue: what counts as curved


def second_stage(
    solver: QuadraticSolver, program: QuadraticProgram, solution: QPSolution, cost: Cost
) -> tuple[QuadraticProgram, QPSolution]:
    """The program of the second cost and its solution; the first's, with a message, where no solver finds one that
    verifies. The first's is left as it is where it isn't proven best: its values would hold the second to nothing."""
    if solution.status != OPTIMAL:
        return program, solution
    size = solution.residuals.wrench_scale
    rows = size * _best_by(program)
    values = rows @ solution.x
    room = FIRST_STAGE_TOLERANCE * np.maximum(size, np.abs(values))
    n, k, larger = program.n, len(program.rows) - program.n_equalities, _with_larger_shares(program, size)
    missing = n - len(cost.weights)  # unknowns of the first's own
    names = ("",) * len(rows)
    second = replace(
        program,
        hessian=np.pad(cost.hessian, ((0, missing), (0, missing))),
        gradient=np.pad(cost.gradient, (0, missing)),
        constant=cost.constant,
        rows=np.vstack([larger.rows[:k], rows, larger.rows[k:]]),
        lower=np.insert(larger.lower, n + k, values - room),
        upper=np.insert(larger.upper, n + k, values + room),
        lower_names=program.lower_names[: n + k] + names + program.lower_names[n + k :],
        upper_names=program.upper_names[: n + k] + names + program.upper_names[n + k :],
    )
    found = solver.solve(second)
    if found.status != OPTIMAL and not program.cones:  # the first's solution is feasible, whatever daqp says of it
        found = solve_with_clarabel(second)
    if found.status != OPTIMAL:
        second = _held_at(second, values, n + k)
        found = solve_with_clarabel(second)
    return (second, found) if found.status == OPTIMAL else (program, replace(solution, message=LEFT_OPEN))


def _held_at(program: QuadraticProgram, values: Array, start: int) -> QuadraticProgram:
    """The program with the limits from `start` on at values (k,), without room."""
    lower, upper = program.lower.copy(), program.upper.copy()
    lower[start : start + len(values)] = upper[start : start + len(values)] = values
    return replace(program, lower=lower, upper=upper)


def _best_by(program: QuadraticProgram) -> Array:
    """Rows that span H and f."""
    values, vectors = np.linalg.eigh(program.hessian)
    rows = vectors.T[values > CURVATURE_RANK_TOLERANCE * max(float(values.max()), 1e-12)]
    along = program.gradient - rows.T @ (rows @ program.gradient)
    length = float(np.linalg.norm(along))
    return (
        np.vstack([rows, along / length])
        if length > CURVATURE_RANK_TOLERANCE * np.linalg.norm(program.gradient)
        else rows
    )


def _with_larger_shares(program: QuadraticProgram, size: float) -> QuadraticProgram:
    """The program with rows that are no limits, but state its cost, `size` times larger."""
    names = zip(program.lower_names[program.n :], program.upper_names[program.n :], strict=True)
    sizes = np.array([1.0 if low or high else size for low, high in names])
    both = np.append(np.ones(program.n), sizes)
    return replace(program, rows=sizes[:, None] * program.rows, lower=both * program.lower, upper=both * program.upper)
