"""How finely times are stored: of unix time doubles hold a quarter of a microsecond, so that even steps differ."""

from __future__ import annotations

import numpy as np

from ..frames import Array


def stamp_rounding(time: Array) -> float:
    """By how much a difference of two of these times (n,), s, may be off because they are rounded."""
    return float(np.spacing(np.abs(time).max()))
