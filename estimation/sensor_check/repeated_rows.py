"""Poses that were recorded twice: a recorder writes the last one again where no new one came in time. And wrenches of a
sensor that froze, or is at the end of its range (`stuck_wrenches.py`).

Such a row is no measurement: taken as one, the cart stands still in it and then jumps.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ..log_noise.resolution import ROUND_OFF_TOLERANCE, STEP_QUANTILE
from ..log_noise.sentinel_values import without_sentinels
from .stuck_wrenches import without_clipped, without_frozen

MAX_REPEAT_INTERVAL = 0.25
"""s: what repeats for longer rests."""
MIN_LEAP_RATIO = 1.5
"""Times the smallest step: more, after a repetition, than a sensor's resolution makes."""
SPEED_HALF_WINDOW = 0.25
"""s: over which speeds are compared."""
FAST_ROW_QUANTILE, MIN_REPEATED_FRACTION = 0.75, 0.05
"""Share of the rows that go slower than those called fast; share of the latter: fewer repeats are a hiccup."""
SLOW_ROW_RATIO = 0.25
"""Share of a fast row's speed below which a coarse sensor repeats itself, where nothing goes faster."""


def without_repeats(log: RunLog) -> RunLog:
    """The log, with poses, velocities and wrenches that are no measurements as missing samples."""
    velocity = None if log.velocity is None else without_repeated_rows(log.velocity, log.time)
    return replace(with_measured_wrenches(log), pose=without_repeated_rows(log.pose, log.time), velocity=velocity)


def with_measured_wrenches(log: RunLog) -> RunLog:
    """The log, with wrenches of a sensor that froze, or is at the end of its range, as missing samples; numbers that
    stand for no reading are no such end."""
    known = without_sentinels(log)
    arms = {name: without_clipped(without_frozen(arm), log.time) for name, arm in known.arms.items()}
    return replace(known, arms=arms)


def repeats_fast(again: np.ndarray, change: Array) -> bool:
    """Whether rows repeat others (n,) where a log changes fast, by its local `change` (n,): so often, a recorder wrote
    them again; a coarse sensor repeats itself where it goes slowly."""
    fast = change > np.quantile(change, FAST_ROW_QUANTILE) if len(change) else np.zeros(0, dtype=bool)
    return _often(again, fast)


def _often(again: np.ndarray, among: np.ndarray) -> bool:
    return bool(again[among].sum() > MIN_REPEATED_FRACTION * max(among.sum(), 1))


def local_change(rows: Array, time: Array) -> Array:
    """The change (n,) of rows (n, k) over `SPEED_HALF_WINDOW` on either side, all columns together."""
    first, last = (
        np.searchsorted(time, time + side).clip(0, len(time) - 1) for side in (-SPEED_HALF_WINDOW, SPEED_HALF_WINDOW)
    )
    return np.asarray(np.abs(rows[last] - rows[first]).sum(axis=1))


def without_repeated_rows(rows: Array, time: Array) -> Array:
    """Rows (n, k), NaN where they repeat the last one, and the next differs by more than the resolution and than the
    rows around: a cart that starts does not leap."""
    there = np.flatnonzero(np.isfinite(rows).all(axis=1))
    steps = np.abs(np.diff(rows[there], axis=0))
    moved = (steps > ROUND_OFF_TOLERANCE).any(axis=1)
    if moved.all() or not moved.any():
        return rows
    new = np.flatnonzero(np.r_[True, moved])
    first = np.flatnonzero(np.diff(new) > 1)
    begin, after = new[first], new[first + 1]
    is_short = time[there[after]] - time[there[begin]] < MAX_REPEAT_INTERVAL
    begin, after = begin[is_short], after[is_short]
    resolution = np.min(np.where(steps > ROUND_OFF_TOLERANCE, steps, np.inf), axis=0)
    change = local_change(rows[there], time[there])
    per_row = change * float(np.median(np.diff(time))) / (2 * SPEED_HALF_WINDOW)
    slowly = steps[after[change[begin] < SLOW_ROW_RATIO * np.quantile(change, FAST_ROW_QUANTILE)] - 1]
    if len(slowly) and not _often(np.r_[False, ~moved], per_row > np.quantile(slowly, STEP_QUANTILE, axis=0).sum()):
        resolution = np.maximum(resolution, slowly.max(axis=0))
    known, at = rows[there], time[there]
    before = np.abs(known[begin] - known[np.searchsorted(at, at[begin] - SPEED_HALF_WINDOW)])
    leaps, moved_before = ((way > MIN_LEAP_RATIO * resolution).any(axis=1) for way in (steps[after - 1], before))
    found = rows.copy()
    for k in np.flatnonzero(leaps & (moved_before | (at[begin] - at[0] < SPEED_HALF_WINDOW))):
        found[there[begin[k] + 1 : after[k]]] = np.nan
    return found
