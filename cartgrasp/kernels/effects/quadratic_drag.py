"""`effects/quadratic_drag.py`: parameter coefficient."""

from __future__ import annotations

import math

from ..jit import compiled
from ..situation import EffectValues, KernelSituation, Parts


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    coefficient, velocity = own.parameters[0], at.velocity
    speed = math.sqrt(velocity[0] ** 2 + velocity[1] ** 2)
    for i in range(2):
        out.value[i] -= coefficient * speed * velocity[i]
        out.by_parameters[i, 0] -= speed * velocity[i]
        out.by_velocity[i, i] -= coefficient * speed
        if speed > 0.0:
            for j in range(2):
                out.by_velocity[i, j] -= coefficient * velocity[i] * velocity[j] / speed
