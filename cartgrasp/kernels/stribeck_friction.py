"""`effects/stribeck_friction.py`: parameters breakaway, speed."""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from .jit import compiled
from .situation import Own, Parts, Situation


@compiled
def wrench(at: Situation, own: Own, out: Parts) -> None:
    breakaway, speed, velocity = own.parameters[0], own.parameters[1], at.velocity
    squared = velocity[0] ** 2 + velocity[1] ** 2
    norm = math.sqrt(squared + at.smoothing_speed**2)
    fade = math.exp(-squared / speed**2)
    for i in range(2):
        unit = velocity[i] / norm
        force = -breakaway * fade * unit
        out.value[i] += force
        out.by_parameters[i, 0] -= fade * unit
        out.by_parameters[i, 1] += force * 2.0 * squared / speed**3
        out.by_velocity[i, i] -= breakaway * fade / norm
        for j in range(2):
            out.by_velocity[i, j] -= force * (velocity[j] / norm**2 + 2.0 * velocity[j] / speed**2)


@compiled
def stiction(at: Situation, own: Own, columns: Array) -> int:
    squared, smoothing = at.velocity[0] ** 2 + at.velocity[1] ** 2, at.smoothing_speed**2
    level = own.parameters[0] * math.exp(-squared / own.parameters[1] ** 2) * smoothing / (squared + smoothing)
    columns[0, 0] = columns[1, 1] = level
    return 2
