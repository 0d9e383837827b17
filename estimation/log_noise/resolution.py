"""The steps in which a sensor's values come, read off where it repeats itself.

The smallest difference between values does not tell: what was resampled, averaged or printed again lies anywhere
between two steps, and a sensor that rests still jumps from one to the next.
"""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array

ROUND_OFF_TOLERANCE = 1e-12
"""Largest round-off, in units of the values."""
STEP_QUANTILE = 0.75
"""Quantile of the steps after a repetition that is called one: a few are parts of one, none is more."""
MIN_REPETITIONS = 8
"""Repetitions that tell it."""
ROUNDING_STD = 12**-0.5
"""Standard deviation of what is lost by rounding, in steps."""


def resolution(column: Array) -> float:
    """The resolution of values (n,), NaN where missing: the usual step after a repetition; where few repeat, the
    smallest of all; 0 where none differ."""
    steps = np.abs(np.diff(column[np.isfinite(column)]))
    moved = steps > ROUND_OFF_TOLERANCE
    if not moved.any():
        return 0.0
    after = steps[1:][moved[1:] & ~moved[:-1]]
    return float(np.quantile(after, STEP_QUANTILE) if len(after) >= MIN_REPETITIONS else steps[moved].min())
