"""Somebody or something else pushed for a while: a person, a threshold, a bump.

    fx = force * w(t),    tau = moment * w(t),    w = step(t - start) - step(t - start - duration)

with steps smoothed over `RISE_TIME`. The integral of w is the duration, however short, so the impulse is exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from .compiled import CompiledForce
from .effect import Gate, Parameter

RISE_TIME = 0.005
"""s: the push goes from 12 % to 88 % within twice this."""


@final
@dataclass(frozen=True)
class ExternalPush(CompiledForce):
    """Force `force` (N) along {b}'s x and yaw moment `moment` (N·m) from `start` (s) for `duration` (s)."""

    start: float = 0.0
    duration: float = 0.0
    force: float = 0.0
    moment: float = 0.0

    name = "external_push"
    parameters = (
        Parameter("start", "s", typical=10.0, estimated=False),
        Parameter("duration", "s", typical=0.5, lower=0.0, estimated=False),
        Parameter("force", "N", typical=20.0),
        Parameter("moment", "N·m", typical=5.0),
    )
    gate = Gate.WHILE
    signature = "a force and moment within one short time, whatever the motion"
    constants = (RISE_TIME,)
