"""`effects/wheel_drag_imbalance.py`: parameters force, moment."""

from __future__ import annotations

from cartgrasp.frames import Array

from .jit import compiled
from .situation import Own, Parts, Situation
from .smooth import smooth_sign


@compiled
def wrench(at: Situation, own: Own, out: Parts) -> None:
    force, moment = own.parameters[0], own.parameters[1]
    sign, slope = smooth_sign(at.velocity[0], at.smoothing_speed)
    out.value[0] -= force * sign
    out.value[2] += moment * sign
    out.by_velocity[0, 0] -= force * slope
    out.by_velocity[2, 0] += moment * slope
    out.by_parameters[0, 0] -= sign
    out.by_parameters[2, 1] += sign


@compiled
def stiction(at: Situation, own: Own, columns: Array) -> int:
    sign, _ = smooth_sign(at.velocity[0], at.smoothing_speed)
    columns[0, 0] = -(1.0 - sign * sign) * own.parameters[0]
    columns[0, 2] = (1.0 - sign * sign) * own.parameters[1]
    return 1
