"""Samples that no motion and no push explains: a value far from those around it, for three rows at most.

It is left out, so that it is neither smoothed into the motion nor called a push. What lasts longer is kept, but for
numbers that stand for no reading.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cartgrasp.frames import Array, unwrapped
from cartgrasp.logs import RunLog
from cartgrasp.logs.run_log import ArmLog

from .resolution import ROUNDING_STD, resolution
from .sentinel_values import without_sentinels

MEDIAN_WINDOW_ROWS = 9
"""Rows in a window whose middle one is compared with the median: what is there for three rows is not the median."""
OUTLIER_DISTANCE_RATIO = 8.0
"""Times the usual distance from the median in the window."""
GLITCH_NOISE_RATIO = 20.0
"""Times the noise."""
MAX_GLITCH_FRACTION = 0.02
"""Largest share of the rows that are glitches: what happens more often is no accident."""


def without_glitches(log: RunLog, far: float = GLITCH_NOISE_RATIO) -> RunLog:
    """The log, with glitches as missing samples: what is `far` times the noise from its neighbours."""
    log = without_sentinels(log)
    smooth = np.column_stack([log.pose[:, :2], unwrapped(log.pose[:, 2])])
    pose = np.where(_glitches(smooth, far)[:, None], np.nan, log.pose)
    velocity = None if log.velocity is None else _without(log.velocity, far)
    arms = {name: ArmLog(arm.contact, _without(arm.wrench, GLITCH_NOISE_RATIO)) for name, arm in log.arms.items()}
    return replace(log, pose=pose, velocity=velocity, arms=arms)


def _without(rows: Array, far: float) -> Array:
    return np.where(_glitches(rows, far)[:, None], np.nan, rows)


def _glitches(rows: Array, far: float) -> np.ndarray:
    """Where (n,) a value of rows (n, k) is far from those around it; nowhere if that is more often than by accident."""
    found = np.zeros(len(rows), dtype=bool)
    for column in rows.T:
        values = column[np.isfinite(column)]
        if len(values) > MEDIAN_WINDOW_ROWS:
            noise = float(np.median(np.abs(np.diff(values, 2)))) / 1.65
            found |= outlying(column, far * max(noise, resolution(values) * ROUNDING_STD))
    is_often = found.any() and found.mean() > MAX_GLITCH_FRACTION
    return np.zeros_like(found) if is_often else found


def outlying(column: Array, far: float) -> np.ndarray:
    """Where (n,) a value is further than `far` from the median of those around it, and stands out from them."""
    known = np.flatnonzero(np.isfinite(column))
    found = np.zeros(len(column), dtype=bool)
    if len(known) <= MEDIAN_WINDOW_ROWS:
        return found
    values = column[known]
    padded = np.pad(values, MEDIAN_WINDOW_ROWS // 2, mode="reflect")
    around = np.lib.stride_tricks.sliding_window_view(padded, MEDIAN_WINDOW_ROWS)
    middle = np.median(around, axis=1)
    usual = np.median(np.abs(around - middle[:, None]), axis=1)
    far = max(far, np.finfo(float).tiny)
    found[known] = np.abs(values - middle) > np.maximum(far, OUTLIER_DISTANCE_RATIO * usual)
    return found
