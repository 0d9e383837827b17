"""A force/torque sensor with a wrong gain: `recorded = gain * true`.

It scales every inertial and drag parameter alike, so only a prior or a known payload separates it from them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from ..frames import Array
from .effect import HAND_AT_REST, Contribution, HandMotion, Parameter, SensorEffect


@final
@dataclass(frozen=True)
class ForceScale(SensorEffect):
    """The sensor records `gain` times the wrench, on all six axes."""

    gain: float = 1.0

    name = "force_scale"
    parameters = (Parameter("gain", "-", typical=0.05, lower=0.1, upper=10.0, absent=1.0),)
    signature = "every wrench is too large or too small in the same proportion"

    def recorded(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Array:
        return np.asarray(parameters * wrench_a)

    def corrected(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Contribution:
        value = wrench_a / parameters
        return Contribution(
            value,
            by_memory=np.eye(6) / parameters[..., None],
            by_parameters=(-value / parameters)[..., None],
        )
