"""A force/torque sensor with a constant offset: it was not tared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from ..frames import PLANAR, Array
from .effect import HAND_AT_REST, Contribution, HandMotion, Parameter, SensorEffect


@final
@dataclass(frozen=True)
class ForceBias(SensorEffect):
    """The sensor records `fx`, `fy` (N) and `tz` (N·m) too much, in {a}."""

    fx: float = 0.0
    fy: float = 0.0
    tz: float = 0.0

    name = "force_bias"
    parameters = (
        Parameter("fx", "N", typical=2.0),
        Parameter("fy", "N", typical=2.0),
        Parameter("tz", "N·m", typical=0.5),
    )
    signature = "a constant force and moment, also at rest, that keeps its sign when the motion turns"

    def recorded(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Array:
        return wrench_a + self._offset(parameters)

    def corrected(self, wrench_a: Array, parameters: Array, hand: HandMotion = HAND_AT_REST) -> Contribution:
        by_parameters = np.zeros((6, 3))
        by_parameters[PLANAR, (0, 1, 2)] = -1.0
        value = wrench_a - self._offset(parameters)
        return Contribution(value, by_parameters=np.broadcast_to(by_parameters, (*value.shape, 3)))

    def _offset(self, parameters: Array) -> Array:
        offset = np.zeros((*parameters.shape[:-1], 6))
        offset[..., PLANAR] = parameters
        return offset
