"""Rival explanations of one motion, by the sums of squares that each leaves of it while it goes on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from ..sensor_check.evidence import UNEXPLAINED

KEPT = 1.0 - 1.0 / 40.0
"""Share of the sums that is kept at each new block: 10 s of motion are remembered."""
LEAST_ROWS, SHARED = 7.0, 2.0
"""Rows of motion before anything is told, and how many of them count as one: neighbours share blocks."""
EXPLAINED, SOUND = 0.25, 0.05
"""Share of a motion that the best explanation may leave at most; and that sound sensors may leave without a doubt."""


class Rivals(NamedTuple):
    """Sums of squares that explanations leave, sound sensors first; of what is to be explained; and of rows."""

    left: tuple[float, ...]
    whole: float = 0.0
    rows: float = 0.0

    def and_then(self, left: Sequence[float], whole: float) -> Rivals:
        found = tuple([KEPT * old + new for old, new in zip(self.left, left, strict=True)])
        return Rivals(found, KEPT * self.whole + whole, KEPT * self.rows + 1.0)

    @property
    def evidence(self) -> list[float]:
        """Logarithms; all alike where nothing explains it, sound sensors do, or nothing is known yet. The noise is
        integrated out, as in `sensor_check/evidence.py`."""
        least = min(self.left)
        if self.rows < LEAST_ROWS or least > EXPLAINED * self.whole or self.left[0] <= SOUND * self.whole:
            return [0.0] * len(self.left)
        rows = self.rows / SHARED
        return [-0.5 * rows * math.log(left / self.whole + UNEXPLAINED**2) for left in self.left]
