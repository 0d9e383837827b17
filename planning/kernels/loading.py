"""Fills a workspace with a program: plain numpy, done once for what stays the same."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cartgrasp.frames import Array
from planning.quadratic_program import QuadraticProgram

from .workspace import Workspace

MIN_CURVATURE_RATIO = 1e-9  # of the largest
MIN_CURVATURE = 1e-100  # a curvature below is none: its inverse would overflow


def is_strictly_convex(hessian: Array) -> bool:
    if not np.isfinite(hessian).all():
        return False
    curvature = np.linalg.eigvalsh(hessian)
    return bool(curvature[0] > max(MIN_CURVATURE_RATIO * curvature[-1], MIN_CURVATURE))


def load(workspace: Workspace, program: QuadraticProgram) -> bool:
    """Everything of a program without cones, but for the spans. Says whether the Hessian is new."""
    problem, claim = workspace.problem, workspace.claim
    is_new = not np.array_equal(claim.hessian, program.hessian)
    if is_new:
        claim.hessian[:], workspace.inverse[:] = program.hessian, _inverse(program.hessian)
    problem.rows[:] = program.stacked[program.n :]
    problem.lifted[:] = problem.rows @ workspace.inverse
    workspace.held.size[0] = 0
    load_limits(workspace, program)
    load_gradient(workspace, program.gradient, program.constant)
    return is_new


def load_spans(workspace: Workspace, pattern: NDArray[np.bool_]) -> None:
    """`pattern` (n + m, n) says where G may get numbers that aren't zero."""
    workspace.problem.spans[:, :2] = spans(pattern)
    workspace.problem.spans[:, 2:] = spans(pattern @ (workspace.inverse != 0))


def load_limits(workspace: Workspace, program: QuadraticProgram) -> None:
    """What was held stays so as long as only values of equalities change."""
    limits, first = workspace.problem.limits, len(program.lower) - program.n_equalities
    new = np.array([program.lower, program.upper])
    if not np.array_equal(limits[:, :first], new[:, :first]):
        workspace.held.size[0] = 0
    limits[:] = new


def load_gradient(workspace: Workspace, gradient: Array, constant: float) -> None:
    workspace.claim.gradient[:], workspace.claim.constant[0] = gradient, constant
    workspace.problem.free[:] = workspace.inverse @ -gradient


def spans(held: NDArray[np.bool_]) -> Array:
    """First and last + 1 of the entries of each row that are held, shape (rows, 2)."""
    first, last = held.argmax(axis=1), held.shape[1] - held[:, ::-1].argmax(axis=1)
    return np.where(held.any(axis=1, keepdims=True), np.stack([first, last], axis=1), 0)


def _inverse(hessian: Array) -> Array:
    """Exactly as sparse as a diagonal Hessian is."""
    diagonal = np.diagonal(hessian)
    if np.count_nonzero(hessian) == np.count_nonzero(diagonal):
        return np.diag(1.0 / diagonal)
    return np.asarray(np.linalg.inv(hessian))
