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

from .outliers import MEDIAN_WINDOW_ROWS, outlying
from .resolution import ROUNDING_STD, resolution
from .sentinel_values import without_sentinels

GLITCH_NOISE_RATIO = 20.0
"""Times the noise."""
MAX_GLITCH_FRACTION = 0.02
"""Largest share of the rows that are glitches: what happens more often is no accident."""


def without_glitches(log: RunLog, far: float = GLITCH_NOISE_RATIO) -> RunLog:
    """The log, with glitches as missing samples: what is `far` times the noise from its neighbours."""
    log = without_sentinels(log)
    heading = np.column_stack([log.pose[:, :2], unwrapped(log.pose[:, 2])])
    arms = {
        name: ArmLog(arm.contact, _without(arm.wrench, arm.wrench, GLITCH_NOISE_RATIO))
        for name, arm in log.arms.items()
    }
    velocity = None if log.velocity is None else _without(log.velocity, log.velocity, far)
    return replace(log, pose=_without(log.pose, heading, far), velocity=velocity, arms=arms)


def _without(rows: Array, smooth: Array, far: float) -> Array:
    """Rows (n, k), NaN where `smooth` (n, k) has a glitch in any column."""
    if len(rows) <= MEDIAN_WINDOW_ROWS:
        return rows
    there = np.any([_glitches(column, far) for column in smooth.T], axis=0)
    if not there.any() or there.mean() > MAX_GLITCH_FRACTION:
        return rows
    return np.where(there[:, None], np.nan, rows)


def _glitches(column: Array, far: float) -> np.ndarray:
    """Where (n,) a value is far from those around it."""
    values = column[np.isfinite(column)]
    noise = float(np.median(np.abs(np.diff(values, 2)))) / 1.65 if len(values) > MEDIAN_WINDOW_ROWS else 0.0
    return outlying(column, far * max(noise, resolution(values) * ROUNDING_STD))
