"""Poses that go on to be elsewhere than believed, and agree with each other: it is the belief that is wrong.

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

from .correction import wrapped
from .jit import compiled
from .schmidt_block import Considered
from .sensor_health import OUTLYING_SHARE

FEWEST, LASTING, PAUSE = 4, 0.1, 0.5
"""Poses, s that they last at least, and s between two at most."""
QUICKEST, DRIFTS = 3.0, 0.1
"""m/s or rad/s: of a cart, and of what velocities that are as believed may leave."""
SURE = 6.0
"""Deviations of a pose."""
UNSURE = 0.3
"""m/s or rad/s: deviation of the velocity with which the motion begins anew."""


@compiled
def is_found(d: Considered, time: float, pose: Array, gate: float) -> bool:
    """Whether a pose (3,), which `d.nis` is of, ends a run that is to be believed."""
    run, first, last, off = d.astray[:3], d.astray[3:6], d.astray[6:9], d.astray[9:]
    for i in range(3):
        if not math.isfinite(pose[i]):
            return False
    if not d.nis[0] > gate:
        run[0] = 0.0
        return False
    if run[0] > 0.0 and pose[0] == last[0] and pose[1] == last[1] and pose[2] == last[2]:
        return False
    apart = time - run[2]
    if run[0] == 0.0 or not apart < PAUSE or not _near(d, pose, last, QUICKEST * apart):
        run[0], run[1] = 0.0, time
        copy(pose, first)
        for i in range(3):
            off[i] = pose[i] - d.mean[i]
    run[0], run[2] = run[0] + 1.0, time
    copy(pose, last)
    if run[0] < FEWEST or time - run[1] < LASTING:
        return False
    velocity = d.health[1]
    moves_as_believed = time - velocity[0] < PAUSE and velocity[1] <= 1.0 and velocity[2] < OUTLYING_SHARE
    return not moves_as_believed or _stays_off(d, pose, off, DRIFTS * (time - run[1]))


@compiled
def begin_anew(d: Considered) -> None:
    """At the last pose of the run, as quick as it went along."""
    run, first, last = d.astray[:3], d.astray[3:6], d.astray[6:9]
    k, lasting = len(d.push), run[2] - run[1]
    cosine, sine = math.cos(last[2]), math.sin(last[2])
    x, y, turn = (last[0] - first[0]) / lasting, (last[1] - first[1]) / lasting, wrapped(last[2] - first[2]) / lasting
    along, across = cosine * x + sine * y, cosine * y - sine * x
    for a in range(k):
        d.mean[3 + a] = d.project[a, 0] * along + d.project[a, 1] * across + d.project[a, 2] * turn
    for i in range(3 + k):
        if i < 3:
            d.mean[i] = last[i]
        d.own[i, :], d.own[:, i], d.slopes[i, :] = 0.0, 0.0, 0.0
        d.own[i, i] = d.variances[i] if i < 3 else UNSURE**2
    run[0] = 0.0


@compiled
def _stays_off(d: Considered, pose: Array, off: Array, most: float) -> bool:
    """Whether a pose is as far off as the first of the run was, to within so many m or rad."""
    now = (pose[0] - d.mean[0], pose[1] - d.mean[1], wrapped(pose[2] - d.mean[2] - off[2]))
    limits = most + SURE * math.sqrt(2.0 * d.variances[0]), most + SURE * math.sqrt(2.0 * d.variances[1])
    turned = abs(now[2]) < most + SURE * math.sqrt(2.0 * d.variances[2])
    return abs(now[0] - off[0]) < limits[0] and abs(now[1] - off[1]) < limits[1] and turned


@compiled
def _near(d: Considered, pose: Array, other: Array, most: float) -> bool:
    x, y, turn = abs(pose[0] - other[0]), abs(pose[1] - other[1]), abs(wrapped(pose[2] - other[2]))
    sure = SURE * math.sqrt(2.0)
    return (
        x < most + sure * math.sqrt(d.variances[0])
        and y < most + sure * math.sqrt(d.variances[1])
        and turn < most + sure * math.sqrt(d.variances[2])
    )
