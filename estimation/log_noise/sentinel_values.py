"""Numbers that stand for "no reading", as recorders write them (-9999, 32767): they are no measurements.

Units may have been converted since, by powers of ten.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import ArmLog, RunLog

SENTINEL_SIGNIFICANDS = (9.9, 9.99, 9.999, 9.9999, 9.99999, 3.2767, 3.2768, 6.5535, 2.147483647, 2.147483648)
"""Significands of numbers that recorders write for no reading: all nines, and the largest whole numbers of two and four
bytes."""
MIN_SENTINEL_RATIO = 10.0
"""Times the span of all other values, or the size of the only one: no reading is so far from them."""
MIN_SENTINEL_SIZE = 1e-3
"""SI: what is smaller is a reading, whatever its digits."""
MIN_OTHER_VALUES = 20
"""Other values."""


def sentinels(column: Array) -> np.ndarray:
    """Where (n,) values stand for no reading."""
    found, known = np.zeros(len(column), dtype=bool), np.isfinite(column)
    while np.count_nonzero(others := known & ~found) > MIN_OTHER_VALUES:
        sizes = np.where(others, np.abs(column), 0.0)
        mark = float(sizes.max())
        rest = column[others & (sizes != mark)]
        if (
            not _is_sentinel(mark)
            or len(rest) < MIN_OTHER_VALUES
            or not mark - (size := np.abs(rest).max()) > MIN_SENTINEL_RATIO * (np.ptp(rest) or size)
        ):
            break
        found |= sizes == mark
    return found


def without_sentinels(log: RunLog) -> RunLog:
    """The log, with such rows as missing samples."""
    velocity = None if log.velocity is None else _without(log.velocity)
    arms = {name: ArmLog(_without(arm.contact), _without(arm.wrench)) for name, arm in log.arms.items()}
    return replace(log, pose=_without(log.pose), velocity=velocity, arms=arms)


def _without(rows: Array) -> Array:
    there = np.any([sentinels(column) for column in rows.T], axis=0)
    return np.where(there[:, None], np.nan, rows) if there.any() else rows


def _is_sentinel(size: float) -> bool:
    """Whether it is one of them, times a power of ten."""
    if not size > MIN_SENTINEL_SIZE:
        return False
    significand = size / 10.0 ** math.floor(math.log10(size))
    return bool(np.isclose(significand, SENTINEL_SIGNIFICANDS, rtol=1e-9, atol=0.0).any())
