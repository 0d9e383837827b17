"""The wrench of a moment, as arms recorded it: what it may be, what is kept of it, and what it does to nu'.

A moment's row begins with its time; then come the time of its wrench's sample (NaN: none), the reduced wrench (f,),
its noise (f, f), its partials by the parameters (f, p), the parameters (p,) that it was worked out at, and by how much
nu' may change at the moment (f,).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cartgrasp.frames import Array
from cartgrasp.kernels.workspace import copy

from .correction import carved, eliminate, normalised_square
from .jit import compiled

WRENCH_HOLD_TIME = 0.1
"""s: for how long a wrench is taken to go on."""
MAX_WRENCH = 1e6
"""N, N·m: more in all is no wrench, nor is NaN."""
WRENCH_STEP_GATE = 14.0
"""Normalised square of a step of the wrench that is no noise."""
MAX_JOLT_ACCELERATION = 100.0
"""m/s² or rad/s²: what such a step may change."""


class MeasuredWrench(NamedTuple):
    """Wrenches (6 n,) of n arms, one after the other; the `grip` (f, 6 n + f): what takes them to the reduced wrench,
    and the noise of that; and what is `believed`, flat: the reduced wrench's partials by the parameters (f, p), these
    (p,), and the mass matrix (f, f)."""

    wrenches: Array
    grip: Array
    believed: Array


def size(f: int, p: int) -> int:
    """The number of entries of a moment's row that are about its wrench."""
    return 1 + f + f * f + f * p + p + f


@compiled
def hold(rows: Array, i: int, time: float, size: int, f: int) -> None:
    """Moment i > 0 begins with the last one's wrench, for as long as that may be held."""
    rows[i, 0] = time
    copy(rows[i - 1, 1 : 1 + size], rows[i, 1 : 1 + size])
    rows[i, 1 + size - f : 1 + size] = 0.0
    if not time - rows[i, 1] < WRENCH_HOLD_TIME:
        rows[i, 1] = math.nan


@compiled
def record_wrench(rows: Array, i: int, time: float, felt: MeasuredWrench, room: Array) -> bool:
    """Moment i's wrench; False where there is none."""
    grip, believed, n = felt.grip, felt.believed, len(felt.wrenches)
    f, total = len(grip), 0.0
    value, step, room = room[:f], room[f : 2 * f], room[2 * f :]
    for a in range(f):
        value[a] = 0.0
        for j in range(n):
            value[a] += grip[a, j] * felt.wrenches[j]
        total += abs(value[a])
    if not total < MAX_WRENCH:
        return False
    row, taught = rows[i, 1:], len(believed) - f * f
    if i > 0 and not math.isnan(rows[i - 1, 1]):
        before, jolt = rows[i - 1, 1:], row[1 + f + f * f + taught : 1 + 2 * f + f * f + taught]
        spread, room = carved(room, f, f)
        for a in range(f):
            step[a], jolt[a] = value[a] - before[1 + a], 0.0
            for b in range(f):
                spread[a, b] = grip[a, n + b] + before[1 + f + f * a + b]
        if not normalised_square(step, spread, room) < WRENCH_STEP_GATE:
            mass, _ = carved(room, f, f)
            copy(believed[taught:], room[: f * f])
            eliminate(mass, step.reshape((f, 1)))
            for a in range(f):
                jolt[a] = min(max(step[a], -MAX_JOLT_ACCELERATION), MAX_JOLT_ACCELERATION)
    row[0] = time
    copy(value, row[1 : 1 + f])
    for a in range(f):
        for b in range(f):
            row[1 + f + f * a + b] = grip[a, n + b]
    copy(believed[:taught], row[1 + f + f * f : 1 + f + f * f + taught])
    return True
