"""Relocalisation: poses that go on to be elsewhere than believed, and agree with each other: it is the belief that is
wrong.

One that is far off is taken for an outlier: it pulls, but can't tear (`correction.py`). What pushed the cart beside the
arms leaves a belief that moves otherwise than the cart, from which all later poses are far off. So a run of such poses
that a cart could have gone along is believed after a while, and the motion begins anew there. Outliers that jump don't
agree; a sensor that stands still repeats its pose to the last digit; and where velocities are measured, poses have to
go where these say. Those are in {s}, so that a heading that is believed wrongly doesn't turn them. Where the belief
goes there as well, only the source of poses can have moved: it is believed when that has lasted for as long as the
belief, and velocities tell the way meanwhile. The first belief is that in which the path is planned, and has lasted.

Of a run: how many, since when, the last time; the first pose, the last one, and what was believed at the first; how far
the cart has gone since by its measured velocities, and up to when; and when the motion last began anew.
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
MIN_MOVED_SOURCE_DURATION = 2.0
"""s that is long enough for any that the belief goes along with."""
MAX_RELOCALISATION_SPEED, MAX_DRIFT_SPEED = 3.0, 0.1
"""m/s or rad/s: of a cart, and of what measured velocities may leave."""
POSE_AGREEMENT_SIGMAS = 6.0
"""Deviations of a pose."""
RESTART_VELOCITY_STD = 0.3
"""m/s or rad/s: deviation of the velocity with which the motion begins anew."""


@compiled
def is_relocalised(d: Considered, time: float, seen: Array, gate: float) -> bool:
    """Whether what is seen (6,), a pose, which `d.nis` is of, and a velocity, ends a run that is to be believed."""
    run, first, last = d.outlier_run[:3], d.outlier_run[3:6], d.outlier_run[6:9]
    believed, way = d.outlier_run[9:12], d.outlier_run[12:16]
    pose, velocity = seen[:3], seen[3:]
    if run[0] > 0.0 and math.isfinite(velocity[0] + velocity[1] + velocity[2]):
        for i in range(3):
            way[i] += velocity[i] * (time - way[3])
        way[3] = time
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
        copy(d.mean[:3], believed)
        way[:3], way[3] = 0.0, time
    run[0], run[2] = run[0] + 1.0, time
    copy(pose, last)
    if run[0] < MIN_RUN_POSES or time - run[1] < MIN_RUN_DURATION:
        return False
    health = d.health[1]
    is_measured = time - health[0] < MAX_RUN_GAP and health[1] <= 1.0 and health[2] < MAX_OUTLIER_FRACTION
    if not is_measured:
        return True
    lasting = time - run[1]
    enough = min(run[1] - d.outlier_run[16], MIN_MOVED_SOURCE_DURATION)
    if lasting < enough and _has_gone(d, d.mean, believed, way, lasting):
        return False
    return _has_gone(d, pose, first, way, lasting)


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
    run[0], d.outlier_run[16] = 0.0, run[2]


@compiled
def _has_gone(d: Considered, pose: Array, begun: Array, way: Array, lasting: float) -> bool:
    """Whether a pose is from where it was as far as velocities say, in so many s."""
    there = (begun[0] + way[0], begun[1] + way[1], begun[2] + way[2])
    return _near(d, pose, there, MAX_DRIFT_SPEED * lasting)


@compiled
def _near(d: Considered, pose: Array, other: tuple[float, float, float], most: float) -> bool:
    """Whether a pose is another to within so many m or rad, and the noise of both."""
    apart = pose[0] - other[0], pose[1] - other[1], wrapped(pose[2] - other[2])
    return agrees(apart, (d.variances[0], d.variances[1], d.variances[2]), most)


@compiled
def agrees(apart: tuple[float, float, float], variances: tuple[float, float, float], most: float) -> bool:
    """Whether two poses that are so far apart are one to within so many m or rad, and the noise of both."""
    is_near = True
    for i in range(3):
        is_near &= abs(apart[i]) < most + POSE_AGREEMENT_SIGMAS * math.sqrt(2.0 * variances[i])
    return is_near
