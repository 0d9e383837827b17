"""Relocalisation: poses that go on to be elsewhere than believed, and agree with each other: it is the belief that is
wrong.

One that is far off is taken for an outlier: it pulls, but can't tear (`correction.py`). What pushed the cart beside the
arms leaves a belief that moves otherwise than the cart, from which all later poses are far off. So a run of such poses
that a cart could have gone along is believed after a while, and the motion begins anew there. Outliers that jump don't
agree; a sensor that stands still repeats its pose to the last digit; and where velocities are measured, and are as
believed, poses may be elsewhere, but not go elsewhere.

Of a run: how many, since when, the last time, the first pose and the last one, and how far off the first one was.
"""

from __future__ import annotations

import math

from cartgrasp.frames import Array
from cartgrasp.kernels.workspace import copy

from .correction import carved, wrapped
from .free_directions import to_free
from .jit import compiled
from .schmidt_block import Considered
from .sensor_health import MAX_OUTLIER_FRACTION

MIN_RUN_POSES, MIN_RUN_DURATION, MAX_RUN_GAP = 4, 0.1, 0.5
"""Poses, s that they last at least, and s between two at most."""
MAX_RELOCALISATION_SPEED, MAX_DRIFT_SPEED = 3.0, 0.1
"""m/s or rad/s: of a cart, and of what velocities that are as believed may leave."""
POSE_AGREEMENT_SIGMAS = 6.0
"""Deviations of a pose."""
RESTART_VELOCITY_STD = 0.3
"""m/s or rad/s: deviation of the velocity with which the motion begins anew."""


@compiled
def is_relocalised(d: Considered, time: float, pose: Array, gate: float) -> bool:
    """Whether a pose (3,), which `d.nis` is of, ends a run that is to be believed."""
    run, first, last, off = d.outlier_run[:3], d.outlier_run[3:6], d.outlier_run[6:9], d.outlier_run[9:]
    for i in range(3):
        if not math.isfinite(pose[i]):
            return False
    if not d.nis[0] > gate:
        run[0] = 0.0
        return False
    if run[0] > 0.0 and pose[0] == last[0] and pose[1] == last[1] and pose[2] == last[2]:
        return False
    apart = time - run[2]
    if (
        run[0] == 0.0
        or not apart < MAX_RUN_GAP
        or not _near(d, pose, (last[0], last[1], last[2]), MAX_RELOCALISATION_SPEED * apart)
    ):
        run[0], run[1] = 0.0, time
        copy(pose, first)
        for i in range(3):
            off[i] = pose[i] - d.mean[i]
    run[0], run[2] = run[0] + 1.0, time
    copy(pose, last)
    if run[0] < MIN_RUN_POSES or time - run[1] < MIN_RUN_DURATION:
        return False
    velocity = d.health[1]
    moves_as_believed = time - velocity[0] < MAX_RUN_GAP and velocity[1] <= 1.0 and velocity[2] < MAX_OUTLIER_FRACTION
    as_off = (d.mean[0] + off[0], d.mean[1] + off[1], d.mean[2] + off[2])
    return not moves_as_believed or _near(d, pose, as_off, MAX_DRIFT_SPEED * (time - run[1]))


@compiled
def restart_motion(d: Considered) -> None:
    """At the last pose of the run, as quick as it went along."""
    run, first, last = d.outlier_run[:3], d.outlier_run[3:6], d.outlier_run[6:9]
    k, lasting = len(d.push), run[2] - run[1]
    turned, _ = carved(d.room, k, 3)
    to_free(d.project, last[2], turned)
    for a in range(k):
        d.mean[3 + a] = turned[a, 0] * (last[0] - first[0]) + turned[a, 1] * (last[1] - first[1])
        d.mean[3 + a] = (d.mean[3 + a] + turned[a, 2] * wrapped(last[2] - first[2])) / lasting
    for i in range(3 + k):
        if i < 3:
            d.mean[i] = last[i]
        d.own[i, :], d.own[:, i], d.slopes[i, :] = 0.0, 0.0, 0.0
        d.own[i, i] = d.variances[i] if i < 3 else RESTART_VELOCITY_STD**2
    run[0] = 0.0


@compiled
def _near(d: Considered, pose: Array, other: tuple[float, float, float], most: float) -> bool:
    """Whether a pose is another to within so many m or rad, and the noise of both."""
    off, is_near = (pose[0] - other[0], pose[1] - other[1], wrapped(pose[2] - other[2])), True
    for i in range(3):
        is_near &= abs(off[i]) < most + POSE_AGREEMENT_SIGMAS * math.sqrt(2.0 * d.variances[i])
    return is_near
