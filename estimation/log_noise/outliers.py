"""Single samples that are far from those around them."""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array

MEDIAN_WINDOW_ROWS = 9
"""Rows in a window whose middle one is compared with the median: what is there for three rows is not the median."""
OUTLIER_DISTANCE_RATIO = 8.0
"""Times the usual distance from the median in the window."""


def outlying(column: Array, far: float) -> np.ndarray:
    """Where (n,) a value is further than `far` from the median of those around it, and stands out from them."""
    known = np.flatnonzero(np.isfinite(column))
    found = np.zeros(len(column), dtype=bool)
    if len(known) <= MEDIAN_WINDOW_ROWS:
        return found
    values = column[known]
    off, usual = _from_median(values)
    found[known] = off > np.maximum(max(far, np.finfo(float).tiny), OUTLIER_DISTANCE_RATIO * usual)
    return found


def _from_median(values: Array) -> tuple[Array, Array]:
    """How far (n,) values are from the median around them, and the median distance in their windows."""
    around = np.lib.stride_tricks.sliding_window_view(
        np.pad(values, MEDIAN_WINDOW_ROWS // 2, mode="reflect"), MEDIAN_WINDOW_ROWS
    )
    middle = np.median(around, axis=1)
    return np.abs(values - middle), np.median(np.abs(around - middle[:, None]), axis=1)
