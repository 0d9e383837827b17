"""Steps of a motion that is followed without wrenches: pose, nu and nu' under white jerk, and their smoothing."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array

from .correction import GATE, add_congruence, take_pose, take_velocity
from .jit import compiled, entry

PATH_FLOOR = 1e-6
"""m, rad: what a step's quadrature may miss."""


class Moment(NamedTuple):
    """Views of a row: mean (d,) and covariance (d, d) as believed, the same two as predicted from the moment before,
    and the transition (d, d) from there; and by how much (1,) the worst sample missed its gate, NaN where none came."""

    mean: Array
    covariance: Array
    ahead: Array
    ahead_covariance: Array
    forth: Array
    worst: Array


class Known(NamedTuple):
    """Basis (3, f), what projects a velocity onto nu (f, 3), variances of pose and velocity (6,), the direction across
    in {b} (2,), and densities (3,) of jerk, of creep sideways, and of turning."""

    basis: Array
    project: Array
    variances: Array
    across_b: Array
    densities: Array


def moment(row: Array, d: int) -> Moment:
    """Of a row (2 d + 3 d² + 1,)."""
    mean, at = row[:d], d
    covariance, at = row[at : at + d * d].reshape((d, d)), at + d * d
    ahead, at = row[at : at + d], at + d
    ahead_covariance, at = row[at : at + d * d].reshape((d, d)), at + d * d
    forth, at = row[at : at + d * d].reshape((d, d)), at + d * d
    return Moment(mean, covariance, ahead, ahead_covariance, forth, row[at:])


def known_of(known: Array, f: int) -> Known:
    """Views of a block (6 f + 11,)."""
    basis, project = known[: 3 * f].reshape((3, f)), known[3 * f : 6 * f].reshape((f, 3))
    at = 6 * f
    return Known(basis, project, known[at : at + 6], known[at + 6 : at + 8], known[at + 8 :])


_moment, _known_of = compiled(moment), compiled(known_of)


@entry
def follow(rows: Array, i: int, step: float, known: Array, news: Array) -> None:
    """Fills row i > 0 from the one before, and takes in `news` (6 + f,): a pose and a velocity (3,), NaN where missing,
    and by how much nu' may have changed at the last moment."""
    f = len(news) - 6
    d = 3 + 2 * f
    before, now, c = _moment(rows[i - 1], d), _moment(rows[i], d), _known_of(known, f)
    _predict(before, now, step, c, news[6:])
    now.worst[0] = math.nan
    _take(now, c, news)


@entry
def take(rows: Array, i: int, known: Array, news: Array) -> None:
    """As `follow`, with no time gone by."""
    f = len(news) - 6
    _take(_moment(rows[i], 3 + 2 * f), _known_of(known, f), news)


@compiled
def _take(now: Moment, c: Known, news: Array) -> None:
    nothing, none = np.zeros((len(now.mean), 1)), np.zeros((1, 1))
    pose = take_pose(now.mean, now.covariance, nothing, none, news[:3], c.variances[:3])
    velocity = take_velocity(now.mean, now.covariance, nothing, none, news[3:6], c.variances[3:], c.project)
    for miss in (pose / (3 * GATE), velocity / (len(c.project) * GATE)):
        if not math.isnan(miss) and not miss < now.worst[0]:
            now.worst[0] = miss


@compiled
def _predict(before: Moment, now: Moment, step: float, c: Known, jolt: Array) -> None:
    f, d = len(jolt), len(now.mean)
    last, mean, F = before.mean, now.ahead, now.forth
    heading = last[2]
    for a in range(f):
        heading += 0.5 * step * c.basis[2, a] * last[3 + a]
    cosine, sine = math.cos(heading), math.sin(heading)
    turned, leap = np.empty((3, f)), np.zeros(d)
    for i in range(d):
        mean[i] = last[i]
        for j in range(d):
            F[i, j] = 1.0 if i == j else 0.0
    for a in range(f):
        turned[0, a] = cosine * c.basis[0, a] - sine * c.basis[1, a]
        turned[1, a] = sine * c.basis[0, a] + cosine * c.basis[1, a]
        turned[2, a] = c.basis[2, a]
        way = step * last[3 + a] + 0.5 * step**2 * last[3 + f + a]
        for j in range(3):
            F[j, 3 + a], F[j, 3 + f + a] = step * turned[j, a], 0.5 * step**2 * turned[j, a]
            mean[j] += way * turned[j, a]
        F[3 + a, 3 + f + a] = step
        mean[3 + a] += step * last[3 + f + a]
    F[0, 2], F[1, 2] = last[1] - mean[1], mean[0] - last[0]
    for i in range(d):
        for a in range(f):
            leap[i] += F[i, 3 + f + a] * jolt[a]
    P = _noise(turned, step, c, (cosine, sine))
    add_congruence(F, before.covariance, P)
    for i in range(d):
        now.mean[i] = mean[i]
        for j in range(d):
            now.covariance[i, j] = now.ahead_covariance[i, j] = P[i, j] + leap[i] * leap[j]


@compiled
def _noise(turned: Array, step: float, c: Known, direction: tuple[float, float]) -> Array:
    """Of white jerk, creep and turning, over a step; the path's directions (3, f) by the heading halfway."""
    f, jerk = turned.shape[1], c.densities[0]
    noise = np.zeros((3 + 2 * f, 3 + 2 * f))
    for a in range(f):
        v, w = 3 + a, 3 + f + a
        for i in range(3):
            for j in range(3):
                noise[i, j] += jerk * step**5 / 20 * turned[i, a] * turned[j, a]
            noise[i, v] = noise[v, i] = jerk * step**4 / 8 * turned[i, a]
            noise[i, w] = noise[w, i] = jerk * step**3 / 6 * turned[i, a]
        noise[v, v], noise[w, w] = jerk * step**3 / 3, jerk * step
        noise[v, w] = noise[w, v] = jerk * step**2 / 2
    cosine, sine = direction
    across_b = c.across_b
    sideways = (cosine * across_b[0] - sine * across_b[1], sine * across_b[0] + cosine * across_b[1])
    for a in range(2):
        for b in range(2):
            noise[a, b] += c.densities[1] * step * sideways[a] * sideways[b]
        noise[a, a] += PATH_FLOOR**2
    noise[2, 2] += c.densities[2] * step + PATH_FLOOR**2
    return noise


@entry
def smooth(rows: Array, means: Array, covariances: Array, weights: Array, of_sums: Array) -> None:
    """Each row with what was measured after it, too (Rauch, Tung and Striebel 1965), into `means` (n, d) and
    `covariances` (n, d, d); and into `of_sums` (q, d, d) the covariances of sums over rows by `weights` (q, n)."""
    n, d = means.shape
    last = _moment(rows[n - 1], d)
    means[n - 1], covariances[n - 1] = last.mean, last.covariance
    beside = np.zeros_like(of_sums)
    for j in range(len(weights)):
        of_sums[j] = weights[j, n - 1] ** 2 * last.covariance
    for i in range(n - 2, -1, -1):
        here, after = _moment(rows[i], d), _moment(rows[i + 1], d)
        back = np.ascontiguousarray(np.linalg.solve(after.ahead_covariance, after.forth @ here.covariance).T)
        means[i] = here.mean + back @ (means[i + 1] - after.ahead)
        covariances[i] = here.covariance + back @ (covariances[i + 1] - after.ahead_covariance) @ back.T
        for j in range(len(weights)):
            beside[j] = back @ (weights[j, i + 1] * covariances[i + 1] + beside[j])
            if weights[j, i] != 0.0:
                with_later = weights[j, i] * beside[j]
                of_sums[j] += weights[j, i] ** 2 * covariances[i] + with_later + with_later.T
