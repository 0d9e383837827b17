"""Somebody or something else pushed for a while: a person, a threshold, a bump.

    fx = force * w(t),    tau = moment * w(t),    w = step(t - start) - step(t - start - duration)

with steps smoothed over `RISE`. The integral of w is the duration, however short, so the impulse is exact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ..frames import Array
from .effect import Contribution, ForceEffect, Parameter, Situation, smooth_step

RISE = 0.005
"""s: the push goes from 12 % to 88 % within twice this."""


@final
@dataclass(frozen=True)
class ExternalPush(ForceEffect):
    """Force `force` (N) along {b}'s x and yaw moment `moment` (N·m) from `start` (s) for `duration` (s)."""

    start: float = 0.0
    duration: float = 0.0
    force: float = 0.0
    moment: float = 0.0

    name: ClassVar[str] = "external_push"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("start", "s", typical=10.0, estimated=False),
        Parameter("duration", "s", typical=0.5, lower=0.0, estimated=False),
        Parameter("force", "N", typical=20.0),
        Parameter("moment", "N·m", typical=5.0),
    )
    signature: ClassVar[str] = "a force and moment within one short time, whatever the motion"

    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        start, duration, force, moment = np.moveaxis(parameters, -1, 0)
        since = np.asarray(situation.time, dtype=float) - start
        on, on_slope = smooth_step(since, RISE)
        off, off_slope = smooth_step(since - duration, RISE)
        strength = np.stack([force, np.zeros_like(force), moment], axis=-1)
        value = (on - off)[..., None] * strength
        by_parameters = np.zeros((*value.shape, 4))
        by_parameters[..., 0] = (off_slope - on_slope)[..., None] * strength
        by_parameters[..., 1] = off_slope[..., None] * strength
        by_parameters[..., 0, 2] = by_parameters[..., 2, 3] = on - off
        return Contribution(value, by_parameters=by_parameters)
