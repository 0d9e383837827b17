"""One fixed wheel drags more than the other: a yaw moment whenever the cart rolls.

    fx = -force * sign u,    tau = moment * sign u

A wheel at (0, y) that drags by F more is `force = F`, `moment = y F`: a tight left wheel turns a cart that
rolls forward to the left.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ..frames import Array
from .effect import Contribution, ForceEffect, Parameter, Situation, coulomb


@final
@dataclass(frozen=True)
class WheelDragImbalance(ForceEffect):
    """Drag `force` (N) and yaw moment `moment` (N·m, positive: to the left when rolling forward)."""

    force: float = 0.0
    moment: float = 0.0

    name: ClassVar[str] = "wheel_drag_imbalance"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("force", "N", typical=3.0, lower=0.0),
        Parameter("moment", "N·m", typical=1.0),
    )
    signature: ClassVar[str] = "a yaw moment, flat in speed, that changes sign with the direction of rolling"

    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        sign, slope = coulomb(situation.velocity_b[..., 0])
        lead = np.broadcast_shapes(sign.shape, parameters.shape[:-1])
        by_parameters = np.zeros((*lead, 3, 2))
        by_parameters[..., 0, 0], by_parameters[..., 2, 1] = -sign, sign
        by_velocity = np.zeros((*lead, 3, 3))
        by_velocity[..., 0, 0], by_velocity[..., 2, 0] = (
            -parameters[..., 0] * slope,
            parameters[..., 1] * slope,
        )
        value = np.asarray((by_parameters @ parameters[..., None])[..., 0])
        return Contribution(value, by_velocity=by_velocity, by_parameters=by_parameters)

    def stiction(self, situation: Situation, memory: Array, parameters: Array) -> Array:
        sign, _ = coulomb(situation.velocity_b[..., 0])
        force, moment = parameters[..., 0], parameters[..., 1]
        pull = np.stack([-force, np.zeros_like(force), moment], axis=-1)
        return np.asarray(((1.0 - sign**2)[..., None] * pull)[..., None])
