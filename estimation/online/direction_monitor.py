"""Which way a cart goes that can't slip sideways, against its heading: a turned frame, or a heading that drifted."""

from __future__ import annotations

import math
from typing import NamedTuple

from .competing_explanations import with_block


class DirectionMonitor(NamedTuple):
    """Sums of ways along the heading and beside it (m²), forgotten as those of `CompetingExplanations` are: squares,
    and products of the two."""

    along: float = 0.0
    both: float = 0.0
    beside: float = 0.0

    def and_then(self, along: float, beside: float) -> DirectionMonitor:
        """With ways (m) of one more block."""
        return DirectionMonitor(*with_block(self, (along * along, along * beside, beside * beside)))

    @property
    def angle(self) -> float:
        """rad, of the way against the heading, of a half turn: the first principal direction."""
        return 0.5 * math.atan2(2.0 * self.both, self.along - self.beside)

    @property
    def left(self) -> float:
        """What goes sideways (m²) of a heading that is turned by this angle."""
        whole, apart = self.along + self.beside, math.hypot(self.along - self.beside, 2.0 * self.both)
        return max(0.5 * (whole - apart), 0.0)
