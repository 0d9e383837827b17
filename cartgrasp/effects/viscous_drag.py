"""Viscous drag: N(q, qd) of (4), the paper's sigma."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ..frames import Array
from .effect import Contribution, ForceEffect, Parameter, Situation


@final
@dataclass(frozen=True)
class ViscousDrag(ForceEffect):
    """Force `-linear (u, w)` and moment `-angular r`."""

    linear: float = 0.0
    angular: float = 0.0

    name: ClassVar[str] = "viscous_drag"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("linear", "N·s/m", typical=5.0, lower=0.0),
        Parameter("angular", "N·m·s/rad", typical=2.0, lower=0.0),
    )
    signature: ClassVar[str] = "forward force in proportion to speed, yaw moment in proportion to yaw rate"

    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        velocity = situation.velocity_b
        damping = parameters[..., (0, 0, 1)]
        value = -damping * velocity
        by_velocity = -damping[..., :, None] * np.eye(3)
        by_parameters = np.zeros((*value.shape, 2))
        by_parameters[..., :2, 0] = -velocity[..., :2]
        by_parameters[..., 2, 1] = -velocity[..., 2]
        return Contribution(value, by_velocity=by_velocity, by_parameters=by_parameters)
