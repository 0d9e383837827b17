"""Competing explanations of one motion, by the sums of squares that each leaves of it while it goes on."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from ..sensor_check.evidence import UNEXPLAINED_FRACTION

BLOCK_FORGETTING_FACTOR = 1.0 - 1.0 / 40.0
"""Share of the sums that is kept at each new block: 10 s of motion are remembered."""
MIN_EVIDENCE_ROWS, ROWS_PER_INDEPENDENT_ROW = 7.0, 2.0
"""Rows of motion before anything is told, and how many of them count as one: neighbours share blocks."""
MAX_UNEXPLAINED_FRACTION, MAX_SOUND_RESIDUAL_FRACTION = 0.25, 0.05
"""Share of a motion that the best explanation may leave at most; and that sound sensors may leave without a doubt."""
RETAINED_PROBABILITY = 0.5
"""Probability down to which what was told stays so."""


def with_block(sums: Sequence[float], more: Sequence[float]) -> tuple[float, ...]:
    """Sums with what a new block adds, of which older ones fade."""
    return tuple([BLOCK_FORGETTING_FACTOR * old + new for old, new in zip(sums, more, strict=True)])


class CompetingExplanations(NamedTuple):
    """Sums of squares that explanations leave, sound sensors first; of what is to be explained; and of that squared."""

    left: tuple[float, ...]
    whole: float = 0.0
    squared: float = 0.0

    def and_then(self, left: Sequence[float], whole: float) -> CompetingExplanations:
        """With a row more, of which no more is left than there is: one pose that jumps is not to outweigh them all."""
        found = with_block(self.left, [min(new, whole) for new in left])
        squared = BLOCK_FORGETTING_FACTOR**2 * self.squared + whole * whole
        return CompetingExplanations(found, BLOCK_FORGETTING_FACTOR * self.whole + whole, squared)

    @property
    def rows(self) -> float:
        """How many rows count: Kish's effective size, since those with little to explain tell little."""
        return self.whole * self.whole / self.squared if self.squared > 0.0 else 0.0

    @property
    def evidence(self) -> list[float]:
        """Logarithms; all alike where nothing explains it, sound sensors do, or nothing is known yet. The noise is
        integrated out, as in `sensor_check/evidence.py`."""
        least = min(self.left)
        if (
            self.rows < MIN_EVIDENCE_ROWS
            or least > MAX_UNEXPLAINED_FRACTION * self.whole
            or self.left[0] <= MAX_SOUND_RESIDUAL_FRACTION * self.whole
        ):
            return [0.0] * len(self.left)
        rows = self.rows / ROWS_PER_INDEPENDENT_ROW
        return [-0.5 * rows * math.log(left / self.whole + UNEXPLAINED_FRACTION**2) for left in self.left]
