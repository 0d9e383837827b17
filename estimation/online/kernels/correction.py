"""A measurement taken in, by Joseph's form `(I - K H) P (I - K H)ᵀ + K R Kᵀ` (physics.md). Kernels make no arrays: what
they need on the way they carve out of `room`."""

from __future__ import annotations

import math
from typing import NamedTuple

from cartgrasp.frames import Array
from cartgrasp.kernels.workspace import copy

from .free_directions import to_free
from .jit import compiled

INNOVATION_GATE = 25.0
"""Gate on the normalised square by component. A sample beyond it counts as if its noise were larger; outliers pull, but
can't tear."""
MIN_ROW_VARIANCE = 1e-10
"""Variance that every row has at least."""
MISSING_VARIANCE = 1e12
"""Variance of a number that is missing."""


class Believed(NamedTuple):
    """Mean (n,) of a state; what is not known of it is `own + slopes @ beside @ slopesᵀ`, (n, n), where `beside`
    (f, f) is the covariance of parameters that are not taught here (a Schmidt-Kalman filter's)."""

    mean: Array
    own: Array
    slopes: Array
    beside: Array


@compiled
def carved(room: Array, n: int, m: int) -> tuple[Array, Array]:
    """A matrix (n, m), and the rest of the room."""
    return room[: n * m].reshape((n, m)), room[n * m :]


@compiled
def correct(b: Believed, where: tuple[int, int], residual: Array, R: Array, room: Array) -> float:
    """Measured, where: m numbers of the mean from `first` on, to within a residual (m,) with noise R (m, m). Changes
    all that is believed but `beside`; returns the NIS, before an outlier's noise is widened. A compiler that knows m
    makes it twice as fast."""
    (first, m), n, f = where, len(b.mean), len(b.beside)
    K, room = carved(room, n, m)
    S, room = carved(room, m, m)
    scale, nis = 1.0, 0.0
    _covary(b, where, K, room)
    for again in range(2):
        for a in range(m):
            for c in range(m):
                S[a, c] = K[first + a, c] + scale * (R[a, c] + (MIN_ROW_VARIANCE if a == c else 0.0))
        factorise(S, m)
        if again == 0:
            nis = _whitened(S, residual, room, m)
            scale = nis / (INNOVATION_GATE * m)
            if not scale > 1.0:
                scale = 1.0
                break
    left, room = carved(room, n, n)
    noisy, room = carved(room, n, m)
    for i in range(n):
        _solve(S, K[i], m)
        for a in range(m):
            b.mean[i] += K[i, a] * residual[a]
    for i in range(n):
        for j in range(max(i + 1, first + m)):
            value = b.own[i, j]
            for a in range(m):
                value -= K[i, a] * b.own[first + a, j]
            left[i, j] = value
        for a in range(m):
            value = -left[i, first + a]
            for c in range(m):
                value += K[i, c] * scale * (R[c, a] + (MIN_ROW_VARIANCE if a == c else 0.0))
            noisy[i, a] = value
    for i in range(n):
        for j in range(i + 1):
            value = left[i, j]
            for a in range(m):
                value += noisy[i, a] * K[j, a]
            b.own[i, j] = b.own[j, i] = value
    moved, room = carved(room, m, f)
    for a in range(m):
        copy(b.slopes[first + a], moved[a])
    for i in range(n):
        for a in range(m):
            for q in range(f):
                b.slopes[i, q] -= K[i, a] * moved[a, q]
    return nis


@compiled
def _covary(b: Believed, where: tuple[int, int], out: Array, room: Array) -> None:
    """What is not known of the state with what is not known of the measured numbers, (n, m)."""
    (first, m), n, f = where, len(out), len(b.beside)
    through, _ = carved(room, m, f)
    through[:] = 0.0
    for q in range(f):
        for a in range(m):
            for p in range(f):
                through[a, p] += b.slopes[first + a, q] * b.beside[q, p]
    for i in range(n):
        for a in range(m):
            value = b.own[i, first + a]
            for p in range(f):
                value += b.slopes[i, p] * through[a, p]
            out[i, a] = value


@compiled
def factorise(S: Array, m: int) -> None:
    """Cholesky's, in place."""
    for a in range(m):
        for b in range(a + 1):
            value = S[a, b]
            for c in range(b):
                value -= S[a, c] * S[b, c]
            S[a, b] = math.sqrt(max(value, MIN_ROW_VARIANCE)) if a == b else value / S[b, b]


@compiled
def _whitened(factor: Array, residual: Array, white: Array, m: int) -> float:
    """The residual (m,) by its deviation; returns the square."""
    square = 0.0
    for a in range(m):
        value = residual[a]
        for b in range(a):
            value -= factor[a, b] * white[b]
        white[a] = value / factor[a, a]
        square += white[a] ** 2
    return square


@compiled
def _solve(factor: Array, row: Array, m: int) -> None:
    """Solves for a row in place, by the Cholesky factor."""
    for a in range(m):
        for b in range(a):
            row[a] -= factor[a, b] * row[b]
        row[a] /= factor[a, a]
    for a in range(m - 1, -1, -1):
        for b in range(a + 1, m):
            row[a] -= factor[b, a] * row[b]
        row[a] /= factor[a, a]


@compiled
def eliminate(matrix: Array, right: Array) -> None:
    """Solves `matrix @ x = right`, in place of both, by Gauss and Jordan with pivots taken from the column."""
    n, width = right.shape
    for c in range(n):
        pivot = c
        for i in range(c + 1, n):
            if abs(matrix[i, c]) > abs(matrix[pivot, c]):
                pivot = i
        if pivot != c:
            for j in range(c, n):
                matrix[c, j], matrix[pivot, j] = matrix[pivot, j], matrix[c, j]
            for j in range(width):
                right[c, j], right[pivot, j] = right[pivot, j], right[c, j]
        scale = 1.0 / matrix[c, c]
        for j in range(c, n):
            matrix[c, j] *= scale
        for j in range(width):
            right[c, j] *= scale
        for i in range(n):
            factor = matrix[i, c]
            if i != c and factor != 0.0:
                for j in range(c, n):
                    matrix[i, j] -= factor * matrix[c, j]
                for j in range(width):
                    right[i, j] -= factor * right[c, j]


@compiled
def add_congruence(matrix: Array, covariance: Array, total: Array, room: Array) -> None:
    """Adds `M P Mᵀ` to a symmetric total, which stays so to the last bit."""
    n, m = matrix.shape
    half = room[:m]
    for i in range(n):
        half[:] = 0.0
        for p in range(m):
            value = matrix[i, p]
            if value != 0.0:
                for q in range(m):
                    half[q] += value * covariance[p, q]
        for j in range(i + 1):
            value = total[i, j]
            for q in range(m):
                value += half[q] * matrix[j, q]
            total[i, j] = total[j, i] = value


@compiled
def put(source: Array, into: Array) -> None:
    """Matrices of one shape."""
    for i in range(len(into)):
        copy(source[i], into[i])


@compiled
def wrapped(angle: float) -> float:
    return float(angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi)))


@compiled
def normalised_square(residual: Array, covariance: Array, room: Array) -> float:
    """`rᵀ P⁻¹ r`, (m,) and (m, m), with room (m² + m,)."""
    m = len(residual)
    factor, room = carved(room, m, m)
    for a in range(m):
        copy(covariance[a], factor[a])
        factor[a, a] += MIN_ROW_VARIANCE
    factorise(factor, m)
    return _whitened(factor, residual, room, m)


@compiled
def take_pose(b: Believed, pose: Array, variance: Array, room: Array) -> float:
    """A pose (3,) that may be NaN in parts, of a state that begins with it; NaN where nothing is there."""
    residual, R = room[:3], room[3:12].reshape((3, 3))
    R[:] = 0.0
    seen = 0
    for i in range(3):
        residual[i], R[i, i] = 0.0, MISSING_VARIANCE
        if math.isfinite(pose[i]):
            seen += 1
            off = pose[i] - b.mean[i]
            residual[i], R[i, i] = wrapped(off) if i == 2 else off, variance[i]
    return correct(b, (0, 3), residual, R, room[12:]) if seen > 0 else math.nan


@compiled
def take_velocity(b: Believed, velocity: Array, variance: Array, project: Array, room: Array) -> float:
    """A velocity (3,) in {s}, of a state that has nu after the pose; `project` (k, 3) takes a velocity in {b} to nu."""
    if not (math.isfinite(velocity[0]) and math.isfinite(velocity[1]) and math.isfinite(velocity[2])):
        return math.nan
    k = len(project)
    residual, room = room[:k], room[k:]
    R, room = carved(room, k, k)
    turned, room = carved(room, k, 3)
    to_free(project, b.mean[2], turned)
    for a in range(k):
        residual[a] = -b.mean[3 + a]
        for j in range(3):
            residual[a] += turned[a, j] * velocity[j]
    for a in range(k):
        for c in range(k):
            R[a, c] = 0.0
            for j in range(3):
                R[a, c] += turned[a, j] * variance[j] * turned[c, j]
    if k == 2:
        return correct(b, (3, 2), residual, R, room)
    return correct(b, (3, k), residual, R, room)
