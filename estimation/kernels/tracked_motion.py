"""Steps of a motion that is followed without wrenches: pose, nu and nu' under white jerk, and their smoothing."""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.frames import Array

from .correction import symmetric, take_pose, take_velocity
from .jit import compiled, entry

PATH_FLOOR = 1e-6
"""m, rad: what a step's quadrature may miss."""


@entry
def follow(
    rows: tuple[Array, Array, Array, Array, Array],
    i: int,
    step: float,
    wheels: tuple[Array, Array],
    densities: tuple[float, float, float],
    jolt: Array,
) -> None:
    """Fills row i > 0 of `rows` from the one before: transition (d, d), mean (d,) and covariance (d, d) as predicted,
    and the same two as believed. `wheels`: basis (3, f), and the direction across (2,); `densities`: of jerk, of creep
    sideways, of turning. `jolt` (f,) is by how much nu' may have changed at the last moment."""
    forth, ahead, ahead_covariance, mean, covariance = rows
    basis, across_b = wheels
    f, d = basis.shape[1], mean.shape[1]
    last, now, F = mean[i - 1], ahead[i], forth[i]
    heading = last[2]
    for a in range(f):
        heading += 0.5 * step * basis[2, a] * last[3 + a]
    cosine, sine = math.cos(heading), math.sin(heading)
    F[:] = np.eye(d)
    now[:] = last
    for a in range(f):
        way = step * last[3 + a] + 0.5 * step**2 * last[3 + f + a]
        turned = (cosine * basis[0, a] - sine * basis[1, a], sine * basis[0, a] + cosine * basis[1, a], basis[2, a])
        for j in range(3):
            F[j, 3 + a], F[j, 3 + f + a] = step * turned[j], 0.5 * step**2 * turned[j]
            now[j] += way * turned[j]
        F[3 + a, 3 + f + a] = step
        now[3 + a] += step * last[3 + f + a]
    F[0, 2], F[1, 2] = last[1] - now[1], now[0] - last[0]
    noise = _noise(basis, step, densities[0], (cosine, sine))
    sideways = (cosine * across_b[0] - sine * across_b[1], sine * across_b[0] + cosine * across_b[1])
    for a in range(2):
        for b in range(2):
            noise[a, b] += densities[1] * step * sideways[a] * sideways[b]
        noise[a, a] += PATH_FLOOR**2
    noise[2, 2] += densities[2] * step + PATH_FLOOR**2
    leap = np.ascontiguousarray(F[:, 3 + f :]) @ jolt
    ahead_covariance[i] = symmetric(F @ covariance[i - 1] @ F.T + noise + np.outer(leap, leap))
    mean[i], covariance[i] = now, ahead_covariance[i]


@entry
def take(
    rows: tuple[Array, Array, Array, Array, Array],
    i: int,
    seen: tuple[Array, Array],
    variances: tuple[Array, Array],
    project: Array,
) -> None:
    """A pose and a velocity (3,), NaN where missing, into row i."""
    mean, covariance = rows[3][i], rows[4][i]
    d = len(mean)
    nothing, none = np.zeros((d, 1)), np.zeros((1, 1))
    take_pose(mean, covariance, nothing, none, seen[0], variances[0])
    take_velocity(mean, covariance, nothing, none, seen[1], variances[1], project)


@entry
def smooth(rows: tuple[Array, Array, Array, Array, Array], means: Array, covariances: Array) -> None:
    """Each row with what was measured after it, too (Rauch, Tung and Striebel 1965), into `means` (n, d) and
    `covariances` (n, d, d)."""
    forth, ahead, ahead_covariance, mean, covariance = rows
    n = len(means)
    means[n - 1], covariances[n - 1] = mean[n - 1], covariance[n - 1]
    for i in range(n - 2, -1, -1):
        back = np.ascontiguousarray(np.linalg.solve(ahead_covariance[i + 1], forth[i + 1] @ covariance[i]).T)
        means[i] = mean[i] + back @ (means[i + 1] - ahead[i + 1])
        covariances[i] = covariance[i] + back @ (covariances[i + 1] - ahead_covariance[i + 1]) @ back.T


@compiled
def _noise(basis: Array, step: float, density: float, turned: tuple[float, float]) -> Array:
    """Of white jerk, over a step; the path's directions by the heading halfway."""
    f = basis.shape[1]
    reach = np.zeros((3 + 2 * f, 3 * f))
    for a in range(f):
        reach[0, a] = turned[0] * basis[0, a] - turned[1] * basis[1, a]
        reach[1, a] = turned[1] * basis[0, a] + turned[0] * basis[1, a]
        reach[2, a] = basis[2, a]
        reach[3 + a, f + a] = reach[3 + f + a, 2 * f + a] = 1.0
    powers = np.array(
        [
            [step**5 / 20, step**4 / 8, step**3 / 6],
            [step**4 / 8, step**3 / 3, step**2 / 2],
            [step**3 / 6, step**2 / 2, step],
        ]
    )
    spread = np.zeros((3 * f, 3 * f))
    for i in range(3):
        for j in range(3):
            for a in range(f):
                spread[i * f + a, j * f + a] = density * powers[i, j]
    return reach @ spread @ reach.T
