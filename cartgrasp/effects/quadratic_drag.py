"""Quadratic drag, of air and of soft tyres.

    F = -coefficient * |v| v,    v = (u, w)

which is `-coefficient * u |u|` where the fixed wheels keep w at 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ..frames import Array
from .effect import Contribution, ForceEffect, Parameter, Situation


@final
@dataclass(frozen=True)
class QuadraticDrag(ForceEffect):
    """Drag `coefficient |v|²` against the velocity of {b}'s origin."""

    coefficient: float = 0.0

    name: ClassVar[str] = "quadratic_drag"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("coefficient", "N·s²/m²", typical=3.0, lower=0.0),)
    signature: ClassVar[str] = "forward force that grows with the square of speed"

    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        coefficient = parameters[..., 0]
        velocity = situation.velocity_b * np.array([1.0, 1.0, 0.0])
        speed = np.linalg.norm(velocity, axis=-1)[..., None]
        direction = velocity / np.where(speed > 0, speed, 1.0)
        slope = speed[..., None] * np.diag([1.0, 1.0, 0.0]) + velocity[..., :, None] * direction[..., None, :]
        return Contribution(
            value=-coefficient[..., None] * speed * velocity,
            by_velocity=-coefficient[..., None, None] * slope,
            by_parameters=-(speed * velocity)[..., None],
        )
