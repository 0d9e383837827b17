"""How far a controller's loop is."""

from __future__ import annotations

import math
from typing import NamedTuple

from .caution import MAX_STEP_GAP, Pace
from .protective_stop import DRIVING, ProtectiveStop


class Progress(NamedTuple):
    """At `time` (s), of which `steady_time` (s) never goes back: the pace along the reference, and the stop."""

    time: float = -math.inf
    steady_time: float = 0.0
    pace: Pace = Pace(0.0)
    stop: ProtectiveStop = DRIVING

    def at(self, time: float) -> Progress:
        """At another time (s), with pace and stop as they were; a stamp out of order sets no clock back."""
        is_out_of_order = -MAX_STEP_GAP <= time - self.time < 0.0
        steady_time = self.steady_time + min(max(time - self.time, 0.0), MAX_STEP_GAP)
        return self._replace(time=self.time if is_out_of_order else time, steady_time=steady_time)

    def elapsed(self, time: float, longest: float) -> float:
        """s in which path and hands went on: none in a pause longer than `longest`, nor where the clock went back."""
        elapsed = time - self.time
        return elapsed if 0.0 < elapsed <= longest else 0.0
