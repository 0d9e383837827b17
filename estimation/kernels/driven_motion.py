"""A step of the motion that recorded wrenches drive, with the parameters considered: known to within a covariance,
and not taught by it (Schmidt 1966)."""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.frames import Array

from .correction import eliminate, take_pose, take_velocity
from .jit import compiled, entry


@entry
def predict(
    belief: tuple[Array, Array, Array],
    flow: tuple[Array, Array, Array, Array],
    disturbed: tuple[Array, Array, Array],
    pushed: tuple[Array, Array],
    step: float,
) -> None:
    """Mean (n,), own covariance (n, n) and slopes by the parameters (n, f), in place. `flow`: the rate (n,) and its
    partials by state, parameters (n, f) and wrench (n, 3). `disturbed`: roots of the densities of disturbing wrenches
    (3, q), densities of the rest of the state on its diagonal (n,), and of creep along a direction (2,) of {b}.
    `pushed`: planar wrenches of the reduced one's axes (3, k), and the covariance (k, k) of a reduced wrench that is
    held all the step long.

    The step is `(I - F h/2)⁻¹ h f` and the transition `(I - F h/2)⁻¹ (I + F h/2)`: of second order, and stable where F
    is stiff."""
    mean, own, carried = belief
    rate, by_state, by_parameters, by_wrench = flow
    n, f = carried.shape
    k = pushed[1].shape[0]
    density = _density(mean[2], by_wrench, disturbed)
    half = np.empty((n, n))
    ahead = np.empty((n, n + 1 + f + k))
    for i in range(n):
        for j in range(n):
            half[i, j], ahead[i, j] = -0.5 * step * by_state[i, j], 0.5 * step * by_state[i, j]
        half[i, i], ahead[i, i] = 1.0 + half[i, i], 1.0 + ahead[i, i]
        ahead[i, n] = step * rate[i]
        for p in range(f):
            ahead[i, n + 1 + p] = step * by_parameters[i, p]
        for a in range(k):
            value = 0.0
            for j in range(3):
                value += by_wrench[i, j] * pushed[0][j, a]
            ahead[i, n + 1 + f + a] = step * value
    eliminate(half, ahead)
    added = _congruence(ahead[:, :n], own + 0.5 * step * density)
    driven = _congruence(ahead[:, n + 1 + f :], pushed[1])
    moved = carried.copy()
    for i in range(n):
        mean[i] += ahead[i, n]
        for j in range(n):
            own[i, j] = added[i, j] + driven[i, j] + 0.5 * step * density[i, j]
        for p in range(f):
            value = ahead[i, n + 1 + p]
            for j in range(n):
                value += ahead[i, j] * moved[j, p]
            carried[i, p] = value


@compiled
def _density(heading: float, by_wrench: Array, disturbed: tuple[Array, Array, Array]) -> Array:
    roots, rest, creep = disturbed
    n, q = len(rest), roots.shape[1]
    reach = np.zeros((n, q))
    for i in range(n):
        for c in range(q):
            for j in range(3):
                reach[i, c] += by_wrench[i, j] * roots[j, c]
    density = _congruence(reach, np.eye(q))
    for i in range(n):
        density[i, i] += rest[i]
    cosine, sine = math.cos(heading), math.sin(heading)
    sideways = (cosine * creep[0] - sine * creep[1], sine * creep[0] + cosine * creep[1])
    for i in range(2):
        for j in range(2):
            density[i, j] += sideways[i] * sideways[j]
    return density


@compiled
def _congruence(matrix: Array, covariance: Array) -> Array:
    """`M P Mᵀ`, symmetric to the last bit."""
    n, m = matrix.shape
    half, whole = np.zeros((n, m)), np.empty((n, n))
    for i in range(n):
        for p in range(m):
            value = matrix[i, p]
            if value != 0.0:
                for q in range(m):
                    half[i, q] += value * covariance[p, q]
    for i in range(n):
        for j in range(i + 1):
            value = 0.0
            for q in range(m):
                value += half[i, q] * matrix[j, q]
            whole[i, j] = whole[j, i] = value
    return whole


@entry
def take(
    belief: tuple[Array, Array, Array],
    beside: Array,
    seen: tuple[Array, Array],
    variances: tuple[Array, Array],
    project: Array,
    nis: Array,
) -> None:
    """A pose and a velocity (3,), NaN where missing; `nis` (2,) is filled."""
    mean, own, carried = belief
    nis[0] = take_pose(mean, own, carried, beside, seen[0], variances[0])
    nis[1] = take_velocity(mean, own, carried, beside, seen[1], variances[1], project)
