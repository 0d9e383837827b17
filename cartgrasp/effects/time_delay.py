"""A wrench that is recorded late against the motion: filtered in the sensor, or stamped when it arrived.

Values are not changed, so there is nothing to correct in a sample. Simulated sensors record the wrench of `delay` ago;
`logs.alignment` brings a log's wrenches back to when they happened; online, `estimation.online.delayed_wrenches` does.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from .effect import LeavesWrenches, Parameter


@final
@dataclass(frozen=True)
class TimeDelay(LeavesWrenches):
    """What is recorded at t was felt at `t - delay` (s)."""

    delay: float = 0.0

    name = "time_delay"
    parameters = (Parameter("delay", "s", typical=0.02, lower=0.0, upper=1.0, estimated=False),)
    by_arm = False
    signature = "a force in proportion to the rate at which the recorded force changes"

    @property
    def lateness(self) -> float:
        return self.delay
