"""All numbers of one structure of programs in two blocks of memory: a call then hands over two arrays, not thirty.

`views` says what stands where, for those who fill and read it; kernels have it as `unpack`. What is found (x, y, then
residuals) is at the end, so that one copy takes it along.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array

from ..quadratic_program import Residuals
from .jit import compiled
from .proof import Claim
from .working_set import Held, Ints, Problem

N_PROGRAM_SIZES = 6
N_FOUND = len(Residuals._fields)


class Sizes(NamedTuple):
    """Unknowns, limits (bounds and rows), how many of them are equalities, arms, rows that depend on contacts, and
    free velocities."""

    n: int
    limits: int
    equalities: int
    arms: int = 0
    moving: int = 0
    free: int = 0

    def allocate(self) -> tuple[Array, Ints]:
        n, m, k = self.n, self.limits, self.free
        floats = n * (2 * m + 3 * n + 4 * self.moving + 10) + 3 * m + 3 * (self.arms + k) + 1 + N_FOUND
        ints = np.zeros(N_PROGRAM_SIZES + 1 + n + 4 * m, np.int64)
        ints[:N_PROGRAM_SIZES] = self
        return np.zeros(floats), ints


class Workspace(NamedTuple):
    """Beside a program with what solves it: H⁻¹; points (arms, 3); those last rows that depend on them,
    as a base and slopes along x, y and z, `affine` (4, moving, n); S (3, k); and the residuals."""

    problem: Problem
    held: Held
    claim: Claim
    inverse: Array
    points: Array
    affine: Array
    basis: Array
    found: Array


def views(floats: Array, ints: Ints) -> Workspace:
    n, m, arms, moving, k = ints[0], ints[1], ints[3], ints[4], ints[5]
    at = 0
    rows, at = floats[at : at + m * n].reshape((m, n)), at + m * n
    lifted, at = floats[at : at + m * n].reshape((m, n)), at + m * n
    hessian, at = floats[at : at + n * n].reshape((n, n)), at + n * n
    inverse, at = floats[at : at + n * n].reshape((n, n)), at + n * n
    factor, at = floats[at : at + n * n].reshape((n, n)), at + n * n
    affine, at = floats[at : at + 4 * moving * n].reshape((4, moving, n)), at + 4 * moving * n
    limits, at = floats[at : at + 2 * m].reshape((2, m)), at + 2 * m
    gradient, at = floats[at : at + n], at + n
    free, at = floats[at : at + n], at + n
    slope, at = floats[at : at + n], at + n
    side, at = floats[at : at + n], at + n
    dual, at = floats[at : at + n], at + n
    column, at = floats[at : at + n], at + n
    change, at = floats[at : at + n], at + n
    z, at = floats[at : at + n], at + n
    rest, at = floats[at : at + n], at + n
    points, at = floats[at : at + 3 * arms].reshape((arms, 3)), at + 3 * arms
    basis, at = floats[at : at + 3 * k].reshape((3, k)), at + 3 * k
    constant, at = floats[at : at + 1], at + 1
    x, at = floats[at : at + n], at + n
    y, at = floats[at : at + m], at + m
    found = floats[at : at + N_FOUND]
    count, limit = ints[N_PROGRAM_SIZES : N_PROGRAM_SIZES + 1], ints[N_PROGRAM_SIZES + 1 : N_PROGRAM_SIZES + 1 + n]
    first = N_PROGRAM_SIZES + 1 + n
    spans = ints[first:].reshape((m, 4))
    return Workspace(
        Problem(rows, lifted, limits, free, spans),
        Held(count, limit, side, dual, factor, column, change, z, rest),
        Claim(hessian, gradient, constant, rows, limits, ints[2], x, y, slope),
        inverse,
        points,
        affine,
        basis,
        found,
    )


unpack = compiled(views)
