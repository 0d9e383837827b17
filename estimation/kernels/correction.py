"""A measurement taken in, by Joseph's form `(I - K H) P (I - K H)ᵀ + K R Kᵀ` (physics 9)."""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.frames import Array

from .jit import Indices, compiled, entry

GATE = 25.0
"""Of the normalised square a row: a sample beyond it counts as if its noise were larger; outliers pull, but can't
tear."""
FLOOR = 1e-10
"""Variance that every row has at least."""


@compiled
def correct(mean: Array, own: Array, carried: Array, beside: Array, at: Indices, residual: Array, R: Array) -> float:
    """Measured: `mean[at]` (m,), at most three numbers. `mean` (n,), `own` (n, n) and `carried` (n, f) change in place;
    returns the NIS, before an outlier's noise is widened.

    What is not known of the state is `own + carried @ beside @ carriedᵀ`, where `beside` (f, f) is the covariance of
    parameters that this sample doesn't teach (a Schmidt-Kalman update)."""
    n, m, f = len(mean), len(residual), carried.shape[1]
    PH, S, white = np.empty((n, m)), np.empty((m, m)), np.empty(m)
    for a in range(m):
        for i in range(n):
            PH[i, a] = own[i, at[a]]
        for p in range(f):
            value = 0.0
            for q in range(f):
                value += carried[at[a], q] * beside[q, p]
            for i in range(n):
                PH[i, a] += carried[i, p] * value
    scale, nis = 1.0, 0.0
    for again in range(2):
        for a in range(m):
            for b in range(m):
                S[a, b] = PH[at[a], b] + scale * (R[a, b] + (FLOOR if a == b else 0.0))
        _factor(S)
        if again == 0:
            nis = _whitened(S, residual, white)
            scale = nis / (GATE * m)
            if not scale > 1.0:
                scale = 1.0
                break
    K = PH.copy()
    for i in range(n):
        _solve(S, K[i])
        for a in range(m):
            mean[i] += K[i, a] * residual[a]
    left = own.copy()
    for i in range(n):
        for a in range(m):
            for j in range(n):
                left[i, j] -= K[i, a] * own[at[a], j]
    noisy = np.zeros((n, m))
    for i in range(n):
        for a in range(m):
            for b in range(m):
                noisy[i, a] += K[i, b] * scale * (R[b, a] + (FLOOR if a == b else 0.0))
            noisy[i, a] -= left[i, at[a]]
    for i in range(n):
        for j in range(i + 1):
            value = left[i, j]
            for a in range(m):
                value += noisy[i, a] * K[j, a]
            own[i, j] = own[j, i] = value
    moved = np.empty((m, f))
    for a in range(m):
        moved[a] = carried[at[a]]
    for i in range(n):
        for a in range(m):
            for q in range(f):
                carried[i, q] -= K[i, a] * moved[a, q]
    return nis


@compiled
def _factor(S: Array) -> None:
    """Cholesky's, in place."""
    for a in range(len(S)):
        for b in range(a + 1):
            value = S[a, b]
            for c in range(b):
                value -= S[a, c] * S[b, c]
            S[a, b] = math.sqrt(max(value, FLOOR)) if a == b else value / S[b, b]


@compiled
def _whitened(factor: Array, residual: Array, white: Array) -> float:
    """The residual by its deviation; returns the square."""
    square = 0.0
    for a in range(len(residual)):
        value = residual[a]
        for b in range(a):
            value -= factor[a, b] * white[b]
        white[a] = value / factor[a, a]
        square += white[a] ** 2
    return square


@compiled
def _solve(factor: Array, row: Array) -> None:
    """In place."""
    m = len(row)
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
def add_congruence(matrix: Array, covariance: Array, total: Array) -> None:
    """Adds `M P Mᵀ` to a symmetric total, which stays so to the last bit."""
    n, m = matrix.shape
    half = np.zeros((n, m))
    for i in range(n):
        for p in range(m):
            value = matrix[i, p]
            if value != 0.0:
                for q in range(m):
                    half[i, q] += value * covariance[p, q]
    for i in range(n):
        for j in range(i + 1):
            value = total[i, j]
            for q in range(m):
                value += half[i, q] * matrix[j, q]
            total[i, j] = total[j, i] = value


@compiled
def wrapped(angle: float) -> float:
    return float(angle - 2.0 * math.pi * math.floor((angle + math.pi) / (2.0 * math.pi)))


@entry
def normalised_square(residual: Array, covariance: Array) -> float:
    """`rᵀ P⁻¹ r`, (m,) and (m, m)."""
    factor = covariance + FLOOR * np.eye(len(residual))
    _factor(factor)
    return _whitened(factor, residual, np.empty(len(residual)))


@compiled
def take_pose(mean: Array, own: Array, carried: Array, beside: Array, pose: Array, variance: Array) -> float:
    """A pose (3,) that may be NaN in parts, of a state that begins with it; NaN where nothing is there."""
    at = np.flatnonzero(np.isfinite(pose))
    m = len(at)
    if m == 0:
        return math.nan
    residual, R = np.empty(m), np.zeros((m, m))
    for a in range(m):
        i = at[a]
        residual[a] = wrapped(pose[i] - mean[i]) if i == 2 else pose[i] - mean[i]
        R[a, a] = variance[i]
    return correct(mean, own, carried, beside, at, residual, R)


@compiled
def take_velocity(
    mean: Array, own: Array, carried: Array, beside: Array, velocity: Array, variance: Array, project: Array
) -> float:
    """A velocity (3,) in {s}, of a state that has nu after the pose; `project` (k, 3) takes a velocity in {b} to nu."""
    if not np.isfinite(velocity).all():
        return math.nan
    k, cosine, sine = len(project), math.cos(mean[2]), math.sin(mean[2])
    residual, R, to_free = np.empty(k), np.zeros((k, k)), np.empty((k, 3))
    for a in range(k):
        to_free[a, 0] = project[a, 0] * cosine - project[a, 1] * sine
        to_free[a, 1] = project[a, 0] * sine + project[a, 1] * cosine
        to_free[a, 2] = project[a, 2]
        residual[a] = -mean[3 + a]
        for j in range(3):
            residual[a] += to_free[a, j] * velocity[j]
    for a in range(k):
        for b in range(k):
            for j in range(3):
                R[a, b] += to_free[a, j] * variance[j] * to_free[b, j]
    return correct(mean, own, carried, beside, np.arange(3, 3 + k), residual, R)
