"""A force/torque sensor with a wrong gain: `recorded = gain * true`.

It scales every inertial and drag parameter alike, so only a prior or a known payload separates it from them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ..frames import Array
from ..wheels import WheelSet
from .effect import Contribution, Parameter, SensorEffect

FURTHEST = 2.5
"""Of a gain, or of its inverse. A strain gauge that ages or is overloaded, or a calibration from another sensor, is off
by some tens of per cent, an amplifier in the wrong range by 2; what is further off is a wrong unit or a wrong channel,
and in a search nearly always a wrench that another thing spoils.
"""


@final
@dataclass(frozen=True)
class ForceScale(SensorEffect):
    """The sensor records `gain` times the wrench, on all six axes."""

    gain: float = 1.0

    name: ClassVar[str] = "force_scale"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("gain", "-", typical=0.05, lower=0.1, upper=10.0, absent=1.0),
    )
    signature: ClassVar[str] = "every wrench is too large or too small in the same proportion"

    def implausible(self, wheels: WheelSet, fastest: float) -> str:
        if 1 / FURTHEST <= self.gain <= FURTHEST:
            return ""
        return f"no sensor that measures records {self.gain:.2f} times what is there"

    def recorded(self, wrench_a: Array, parameters: Array) -> Array:
        return np.asarray(parameters * wrench_a)

    def corrected(self, wrench_a: Array, parameters: Array) -> Contribution:
        value = wrench_a / parameters
        return Contribution(
            value,
            by_memory=np.eye(6) / parameters[..., None],
            by_parameters=(-value / parameters)[..., None],
        )
