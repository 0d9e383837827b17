"""Viscous drag that differs between forward and backward: a skewed caster, a brush, a ratcheting bearing.

    fx = -(forward * p + backward * (1 - p)) u,    p = (1 + sign u) / 2

It is continuous, since it is 0 at rest either way.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from ..frames import Array
from .effect import Contribution, ForceEffect, Parameter, Situation, coulomb


@final
@dataclass(frozen=True)
class DirectionalDrag(ForceEffect):
    """Drag `forward u` or `backward u` (N·s/m), added to `viscous_drag`; one may be below 0 where that one's
    `linear` makes up for it."""

    forward: float = 0.0
    backward: float = 0.0

    name: ClassVar[str] = "directional_drag"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("forward", "N·s/m", typical=2.0),
        Parameter("backward", "N·s/m", typical=2.0),
    )
    signature: ClassVar[str] = "forward force in proportion to speed, with another slope when rolling backward"

    def wrench_b(self, situation: Situation, memory: Array, parameters: Array) -> Contribution:
        forward, backward = parameters[..., 0], parameters[..., 1]
        u = situation.velocity_b[..., 0]
        sign, sign_slope = coulomb(u)
        share = (1 + sign) / 2
        damping = forward * share + backward * (1 - share)
        value = np.zeros((*damping.shape, 3))
        by_velocity = np.zeros((*value.shape, 3))
        by_parameters = np.zeros((*value.shape, 2))
        value[..., 0] = -damping * u
        by_velocity[..., 0, 0] = -damping - (forward - backward) * sign_slope / 2 * u
        by_parameters[..., 0, 0], by_parameters[..., 0, 1] = -share * u, -(1 - share) * u
        return Contribution(value, by_velocity=by_velocity, by_parameters=by_parameters)
