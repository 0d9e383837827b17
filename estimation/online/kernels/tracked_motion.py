"""Steps of a motion that is followed without wrenches: pose, nu and nu' under white jerk, and their smoothing."""

from __future__ import annotations

import math
from typing import NamedTuple

from cartgrasp.frames import Array
from cartgrasp.kernels.workspace import copy

from .correction import INNOVATION_GATE, Believed, add_congruence, carved, eliminate, take_pose, take_velocity
from .free_directions import add_creep
from .jit import compiled, entry

MIN_PATH_STD = 1e-6
"""m, rad: what a step's quadrature may miss."""


class Moment(NamedTuple):
    """Views of a moment's row, which they end: mean (d,) and covariance (d, d) as believed, the same two as predicted
    from the moment before, and the transition (d, d) from there; and by how much (1,) the worst sample missed its gate,
    NaN where none came."""

    mean: Array
    covariance: Array
    ahead: Array
    ahead_covariance: Array
    forth: Array
    worst: Array


class Known(NamedTuple):
    """Basis (3, f), what projects a velocity onto nu (f, 3), variances of pose and velocity (6,), the direction across
    in {b} (2,), and densities (3,) of jerk, of creep sideways, and of turning. And `room` for what is worked out on the
    way."""

    basis: Array
    project: Array
    variances: Array
    across_b: Array
    densities: Array
    room: Array


def row_size(d: int) -> int:
    """The number of entries of a moment's row that are about the motion."""
    return 2 * d + 3 * d * d + 1


def moment(row: Array, d: int) -> Moment:
    at = len(row) - (2 * d + 3 * d * d + 1)
    mean, at = row[at : at + d], at + d
    covariance, at = row[at : at + d * d].reshape((d, d)), at + d * d
    ahead, at = row[at : at + d], at + d
    ahead_covariance, at = row[at : at + d * d].reshape((d, d)), at + d * d
    forth, at = row[at : at + d * d].reshape((d, d)), at + d * d
    return Moment(mean, covariance, ahead, ahead_covariance, forth, row[at:])


def known_size(f: int) -> int:
    d = 3 + 2 * f
    return 6 * f + 11 + 2 * (d + 5) ** 2 + 3 * f + d


def known_of(known: Array, f: int) -> Known:
    """Views of a block."""
    basis, project = known[: 3 * f].reshape((3, f)), known[3 * f : 6 * f].reshape((f, 3))
    at = 6 * f
    return Known(basis, project, known[at : at + 6], known[at + 6 : at + 8], known[at + 8 : at + 11], known[at + 11 :])


_moment, _known_of = compiled(moment), compiled(known_of)


@compiled
def follow(rows: Array, i: int, step: float, known: Array, jolt: Array) -> None:
    """Fills row i > 0 from the one before; nu' may have changed by `jolt` (f,) at the last moment."""
    f = len(jolt)
    d = 3 + 2 * f
    now = _moment(rows[i], d)
    _predict(_moment(rows[i - 1], d), now, step, _known_of(known, f), jolt)
    now.worst[0] = math.nan


@compiled
def take(rows: Array, i: int, known: Array, seen: Array, f: int) -> None:
    """What is `seen` (6,) at moment i: a pose and a velocity, NaN where missing."""
    now, c = _moment(rows[i], 3 + 2 * f), _known_of(known, f)
    nothing = now.mean[:0]
    believed = Believed(now.mean, now.covariance, nothing.reshape((len(now.mean), 0)), nothing.reshape((0, 0)))
    pose = take_pose(believed, seen[:3], c.variances[:3], c.room)
    velocity = take_velocity(believed, seen[3:], c.variances[3:], c.project, c.room)
    for miss in (pose / (3 * INNOVATION_GATE), velocity / (len(c.project) * INNOVATION_GATE)):
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
    turned, room = carved(c.room, 3, f)
    leap, room = room[:d], room[d:]
    P, room = carved(room, d, d)
    leap[:] = 0.0
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
    _add_noise(turned, step, c, (cosine, sine), P)
    add_congruence(F, before.covariance, P, room)
    for i in range(d):
        now.mean[i] = mean[i]
        for j in range(d):
            now.covariance[i, j] = now.ahead_covariance[i, j] = P[i, j] + leap[i] * leap[j]


@compiled
def _add_noise(turned: Array, step: float, c: Known, direction: tuple[float, float], noise: Array) -> None:
    """Puts into `noise` (d, d) that of white jerk, creep and turning, over a step; the path's directions (3, f) by the
    heading halfway."""
    f, jerk = turned.shape[1], c.densities[0]
    noise[:] = 0.0
    for a in range(f):
        v, w = 3 + a, 3 + f + a
        for i in range(3):
            for j in range(3):
                noise[i, j] += jerk * step**5 / 20 * turned[i, a] * turned[j, a]
            noise[i, v] = noise[v, i] = jerk * step**4 / 8 * turned[i, a]
            noise[i, w] = noise[w, i] = jerk * step**3 / 6 * turned[i, a]
        noise[v, v], noise[w, w] = jerk * step**3 / 3, jerk * step
        noise[v, w] = noise[w, v] = jerk * step**2 / 2
    add_creep(direction, c.across_b, c.densities[1] * step, noise)
    for a in range(2):
        noise[a, a] += MIN_PATH_STD**2
    noise[2, 2] += c.densities[2] * step + MIN_PATH_STD**2


@entry
def smooth(
    rows: Array, found: tuple[Array, Array], weights: Array, sums: Array, known: Array, span: tuple[int, int]
) -> None:
    """Each row of a span, from its last to its first, with what was measured after it, too (Rauch, Tung and Striebel
    1965), into `means` (n, d) and `covariances` (n, d, d). Later spans come first. Adds to the first f rows of `sums`
    (q, f + d, f) the covariances of sums of nu over the first rows, by `weights` (q, m); the others are what is carried
    from row to row."""
    (means, covariances), f = found, sums.shape[2]
    n, d = means.shape
    back, room = carved(_known_of(known, f).room, d, d)
    for i in range(span[1] - 1, span[0] - 1, -1):
        here = _moment(rows[i], d)
        copy(here.mean, means[i])
        for a in range(d):
            copy(here.covariance[a], covariances[i, a])
        if i + 1 < n:
            _look_back(here, _moment(rows[i + 1], d), (means[i : i + 2], covariances[i : i + 2]), back, room)
        for j in range(len(weights) if i < weights.shape[1] else 0):
            of_sum, beside = sums[j, :f], sums[j, f:]
            if i + 1 < weights.shape[1]:
                _step_beside(back, weights[j, i + 1], covariances[i + 1], beside, room)
            w = weights[j, i]
            for a in range(f):
                for b in range(f):
                    with_later = beside[3 + a, b] + beside[3 + b, a]
                    of_sum[a, b] += w * w * covariances[i, 3 + a, 3 + b] + w * with_later


@compiled
def _look_back(here: Moment, after: Moment, found: tuple[Array, Array], back: Array, room: Array) -> None:
    """Into the first of `means` (2, d) and `covariances` (2, d, d), by the second; leaves in `back` (d, d) what takes
    what is wrong with the moment after to this one, transposed."""
    d, (means, covariances) = len(here.mean), found
    change, room = carved(room, d, d)
    for a in range(d):
        copy(after.ahead_covariance[a], change[a])
        back[a] = 0.0
        for c in range(d):
            forth = after.forth[a, c]
            if forth != 0.0:
                for b in range(d):
                    back[a, b] += forth * here.covariance[c, b]
    eliminate(change, back)
    for a in range(d):
        for b in range(d):
            means[0, a] += back[b, a] * (means[1, b] - after.ahead[b])
            change[a, b] = covariances[1, a, b] - after.ahead_covariance[a, b]
    add_congruence(back.T, change, covariances[0], room)


@compiled
def _step_beside(back: Array, weight: float, covariance: Array, beside: Array, room: Array) -> None:
    """Steps `beside` (d, f) in place. It is the covariance of a moment with the sum over later ones than the next; it
    becomes that with the next in it."""
    d, f = beside.shape
    total, room = carved(room, d, f)
    for a in range(d):
        for b in range(f):
            total[a, b] = weight * covariance[a, 3 + b] + beside[a, b]
            beside[a, b] = 0.0
    for c in range(d):
        for a in range(d):
            for b in range(f):
                beside[a, b] += back[c, a] * total[c, b]
