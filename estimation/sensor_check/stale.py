"""Poses that were recorded twice: a recorder writes the last one again where no new one came in time.

Such a row is no measurement: taken as one, the cart stands still in it and then jumps.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

LONGEST = 0.25
"""s: what repeats for longer rests."""
TINY = 1e-12
"""m, rad: less is round-off."""
RESOLVED = 1.5
"""Times the smallest step: more, after a repetition, than a sensor's resolution makes."""


def without_stale(log: RunLog) -> RunLog:
    """The log, with poses and velocities that repeat the ones before as missing samples."""
    velocity = None if log.velocity is None else _without(log.velocity, log.time)
    return replace(log, pose=_without(log.pose, log.time), velocity=velocity)


def _without(rows: Array, time: Array) -> Array:
    """Rows (n, k), NaN where they repeat the last one, and the next differs by more than the resolution."""
    there = np.flatnonzero(np.isfinite(rows).all(axis=1))
    steps = np.abs(np.diff(rows[there], axis=0))
    moved = (steps > TINY).any(axis=1)
    if moved.all() or not moved.any():
        return rows
    smallest = np.min(np.where(steps > TINY, steps, np.inf), axis=0)
    new = np.flatnonzero(np.r_[True, moved])
    found = rows.copy()
    for k in np.flatnonzero(np.diff(new) > 1):
        first, after = new[k], new[k + 1]
        is_short = time[there[after]] - time[there[first]] < LONGEST
        if is_short and (steps[after - 1] > RESOLVED * smallest).any():
            found[there[first + 1 : after]] = np.nan
    return found
