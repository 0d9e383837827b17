"""What stands where in the block of a motion with parameters considered: a call hands over one array, and copies it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array

from .jit import Indices

N_BLOCK_SIZES = 6
"""Numbers of a plan before the indices of the free parameters: how many states, reduced wrenches, memories, parameters
and free ones, and how many numbers stiction has at most."""


class Considered(NamedTuple):
    """Believed: mean (n,), own covariance (n, n), slopes by the free parameters (n, f); how poised each memory is (m,);
    the last NIS (2,), how sensors do (3, 4), as in `sensor_health.py`, and poses that are astray (17,), as in
    `relocalisation.py`. Of others: parameters (p,) and the free
    ones' covariance (f, f). The last push: its time and that of the one before (2,), the reduced wrench (k,) and its
    covariance (k, k).

    Known: the covariance of an `unknown` push; what lifts a reduced wrench to {b} (3, k), and what projects a velocity
    onto nu (k, 3); variances of pose and velocity (6,); densities of disturbing wrenches (3, 3), of the rest of the
    state on its diagonal (n,), and of creep along a direction (2,) of {b}; and each memory's `spread` (m,).

    And `room` for what is worked out on the way."""

    mean: Array
    own: Array
    slopes: Array
    poise: Array
    nis: Array
    health: Array
    outlier_run: Array
    theta: Array
    beside: Array
    pushed: Array
    push: Array
    push_covariance: Array
    unknown: Array
    lift: Array
    project: Array
    variances: Array
    disturbance: Array
    rest: Array
    creep: Array
    spread: Array
    room: Array


def new_block(plan: Indices) -> Array:
    n, k, m, p, f = plan[:5].tolist()
    kept = 2 * n + n * n + n * f + 2 * m + 2 + 12 + 17 + p + f * f + 2 + k + 2 * k * k + 6 * k + 6 + 9 + 2
    room = 6 * (n + 3) ** 2 + 2 * n * (f + k) + 3 * f + p + int(plan[5]) + 60
    return np.zeros(kept + room)


def parts(block: Array, plan: Indices) -> Considered:
    """Views."""
    n, k, m, p, f = plan[0], plan[1], plan[2], plan[3], plan[4]
    mean, at = block[:n], n
    own, at = block[at : at + n * n].reshape((n, n)), at + n * n
    slopes, at = block[at : at + n * f].reshape((n, f)), at + n * f
    poise, at = block[at : at + m], at + m
    nis, at = block[at : at + 2], at + 2
    health, at = block[at : at + 12].reshape((3, 4)), at + 12
    outlier_run, at = block[at : at + 17], at + 17
    theta, at = block[at : at + p], at + p
    beside, at = block[at : at + f * f].reshape((f, f)), at + f * f
    pushed, at = block[at : at + 2], at + 2
    push, at = block[at : at + k], at + k
    push_covariance, at = block[at : at + k * k].reshape((k, k)), at + k * k
    unknown, at = block[at : at + k * k].reshape((k, k)), at + k * k
    lift, at = block[at : at + 3 * k].reshape((3, k)), at + 3 * k
    project, at = block[at : at + 3 * k].reshape((k, 3)), at + 3 * k
    variances, at = block[at : at + 6], at + 6
    disturbance, at = block[at : at + 9].reshape((3, 3)), at + 9
    rest, at = block[at : at + n], at + n
    creep, at = block[at : at + 2], at + 2
    spread, at = block[at : at + m], at + m
    return Considered(
        mean,
        own,
        slopes,
        poise,
        nis,
        health,
        outlier_run,
        theta,
        beside,
        pushed,
        push,
        push_covariance,
        unknown,
        lift,
        project,
        variances,
        disturbance,
        rest,
        creep,
        spread,
        block[at:],
    )
