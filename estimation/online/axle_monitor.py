"""Where a cart that can't slip sideways turns about, while it moves: the middle of its axle, if its file is right."""

from __future__ import annotations

import math
from typing import NamedTuple

from ..sensor_check.axle import MAX_SIDESLIP_RATIO, axle_suspicion
from ..sensor_check.suspicion import Suspicion
from .competing_explanations import MIN_EVIDENCE_ROWS, ROWS_PER_INDEPENDENT_ROW, with_block

MIN_TURN_CORRELATION = 0.5
"""Least correlation of a turn with the one before: what turns goes on to, and noise of headings turns back."""


class AxleMonitor(NamedTuple):
    """The last turn (rad). And sums, forgotten as those of `CompetingExplanations` are: of turns times the ones before,
    and of their squares (rad²), of turns times slips that the file's axle leaves (rad m), of squares of such slips and
    of ways (m²), and of rows."""

    last: float = 0.0
    lasting: float = 0.0
    turned: float = 0.0
    pulled: float = 0.0
    slipped: float = 0.0
    way: float = 0.0
    rows: float = 0.0

    def and_then(self, turn: float, slip: float, way: float) -> AxleMonitor:
        """With a turn (rad), a slip (m) and the square of a way (m²) more."""
        new = turn * self.last, turn * turn, slip * turn, slip * slip, way, 1.0
        return AxleMonitor(turn, *with_block(self[1:], new))

    @property
    def left(self) -> float:
        """What goes sideways (m²) of an axle that is where it seems to be."""
        return self.slipped - (self.pulled * self.pulled / self.turned if self.turned > 0.0 else 0.0)

    def suspicion(self, axle_x: float, least: float) -> Suspicion | None:
        """`offset` of the pose, where it is as probable at least; None where too little is seen to turn, or the cart
        slips whatever it turns about."""
        if self.rows < MIN_EVIDENCE_ROWS or not self.lasting > MIN_TURN_CORRELATION * self.turned:
            return None
        off, left = -self.pulled / self.turned, self.left
        if not 0.0 <= left <= MAX_SIDESLIP_RATIO**2 * self.way:
            return None
        std = math.sqrt(left * ROWS_PER_INDEPENDENT_ROW / self.rows / self.turned)
        return axle_suspicion(axle_x + off, axle_x, std, least)
