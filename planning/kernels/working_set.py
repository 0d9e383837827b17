"""The limits that a dual active-set method holds, and L Lᵀ, the Gram matrix of their normals.

Limit i bounds G_i x, with G = (I, R) as in quadratic_program.py; its lifted normal is V_i = H⁻¹ G_iᵀ. With A the
limits held, the Gram matrix is G_A H⁻¹ G_Aᵀ: L grows by a row and loses one by Givens rotations. Most normals have
few numbers that aren't zero, side by side: `spans` says where, so that sums leave the rest out.
"""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from cartgrasp.frames import Array

from .jit import compiled

Ints = NDArray[np.int64]
CANCELLATION_RATIO = 1e-3  # of a normal's square, beside the normals held


class Problem(NamedTuple):
    """G and V (n + m, n), limits (2, n + m), lower and upper, free = -H⁻¹ f (n,), and the spans of G and V
    (n + m, 4): first and last + 1 of each."""

    rows: Array
    lifted: Array
    limits: Array
    free: Array
    spans: Ints


class Held(NamedTuple):
    """The first `size[0]` entries are held: limit, side (1 upper, -1 lower, 0 equality), multiplier, L (n, n). The
    rest is the last `direction`: G_A V_p times L⁻¹ and times (L Lᵀ)⁻¹, and z; and scratch."""

    size: Ints
    limit: Ints
    side: Array
    dual: Array
    factor: Array
    column: Array
    change: Array
    z: Array
    rest: Array

    @classmethod
    def nothing(cls, n: int) -> Self:
        count, limit = np.zeros(1, np.int64), np.zeros(n, np.int64)
        return cls(count, limit, np.zeros(n), np.zeros(n), np.zeros((n, n)), *np.zeros((4, n)))


@compiled
def image(problem: Problem, i: int, x: Array) -> float:
    """G_i x."""
    rows, spans, total = problem.rows, problem.spans, 0.0
    for j in range(spans[i, 0], spans[i, 1]):
        total += rows[i, j] * x[j]
    return total


@compiled
def product(problem: Problem, i: int, p: int) -> float:
    """G_i V_p."""
    rows, lifted, spans, total = problem.rows, problem.lifted, problem.spans, 0.0
    for j in range(max(spans[i, 0], spans[p, 2]), min(spans[i, 1], spans[p, 3])):
        total += rows[i, j] * lifted[p, j]
    return total


@compiled
def direction(problem: Problem, held: Held, p: int) -> float:
    """Finds how what is held and x move with the multiplier of limit p; returns G_p z. Where little of V_p is left,
    rounding is taken off by a second round."""
    limit, column, change, z, lifted = held.limit, held.column, held.change, held.z, problem.lifted
    for k in range(held.size[0]):
        column[k] = product(problem, limit[k], p)
    solve_lower(held, column)
    for k in range(held.size[0]):
        change[k] = column[k]
    solve_upper(held, change)
    for j in range(len(z)):
        z[j] = lifted[p, j]
    subtract(problem, held, change, z)
    left = image(problem, p, z)
    if left > CANCELLATION_RATIO * product(problem, p, p):
        return left
    rest = held.rest
    for k in range(held.size[0]):
        rest[k] = image(problem, limit[k], z)
    solve_lower(held, rest)
    solve_upper(held, rest)
    for k in range(held.size[0]):
        change[k] += rest[k]
    subtract(problem, held, rest, z)
    return image(problem, p, z)


@compiled
def subtract(problem: Problem, held: Held, shares: Array, v: Array) -> None:
    """v := v - V_Aᵀ shares."""
    limit, lifted, spans = held.limit, problem.lifted, problem.spans
    for k in range(held.size[0]):
        i = limit[k]
        for j in range(spans[i, 2], spans[i, 3]):
            v[j] -= shares[k] * lifted[i, j]


@compiled
def solve_lower(held: Held, b: Array) -> None:
    """b := L⁻¹ b."""
    factor = held.factor
    for i in range(held.size[0]):
        total = b[i]
        for j in range(i):
            total -= factor[i, j] * b[j]
        b[i] = total / factor[i, i]


@compiled
def solve_upper(held: Held, b: Array) -> None:
    """b := L⁻ᵀ b."""
    factor = held.factor
    for i in range(held.size[0] - 1, -1, -1):
        b[i] /= factor[i, i]
        for j in range(i):
            b[j] -= factor[i, j] * b[i]


@compiled
def hold(held: Held, p: int, side: float, left: float) -> None:
    """Holds limit p, whose `direction` has just been found, with G_p z = `left`."""
    k, factor, column = held.size[0], held.factor, held.column
    held.limit[k], held.side[k], held.dual[k] = p, side, 0.0
    for j in range(k):
        factor[k, j] = column[j]
    factor[k, k] = np.sqrt(left)
    held.size[0] = k + 1


@compiled
def let_go(held: Held, k: int) -> None:
    """Entries below k move up; L without its row k is made triangular again."""
    last, factor, limit, side, dual = held.size[0] - 1, held.factor, held.limit, held.side, held.dual
    for i in range(k, last):
        limit[i], side[i], dual[i] = limit[i + 1], side[i + 1], dual[i + 1]
        for j in range(i + 2):
            factor[i, j] = factor[i + 1, j]
    for i in range(k, last):
        length = np.sqrt(factor[i, i] ** 2 + factor[i, i + 1] ** 2)
        c, s = factor[i, i] / length, factor[i, i + 1] / length
        factor[i, i] = length
        for r in range(i + 1, last):
            one, other = factor[r, i], factor[r, i + 1]
            factor[r, i], factor[r, i + 1] = c * one + s * other, c * other - s * one
    held.size[0] = last
