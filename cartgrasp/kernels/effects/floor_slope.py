"""`effects/floor_slope.py`: parameters grade_x, grade_y; the constant is gravity."""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from ..jit import compiled
from ..situation import HIGH_ROWS, EffectValues, KernelSituation, Parts


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    grade_x, grade_y, gravity = own.parameters[0], own.parameters[1], own.constants[0]
    cosine, sine = math.cos(at.pose[2]), math.sin(at.pose[2])
    pull_x = -gravity * (cosine * grade_x + sine * grade_y)
    pull_y = -gravity * (cosine * grade_y - sine * grade_x)
    for i in range(3):
        out.value[i] += _pulled(i, pull_x, pull_y, at.phi)
        out.by_pose[i, 2] += _pulled(i, pull_y, -pull_x, at.phi)
        out.by_parameters[i, 0] += _pulled(i, -gravity * cosine, gravity * sine, at.phi)
        out.by_parameters[i, 1] += _pulled(i, -gravity * sine, -gravity * cosine, at.phi)
    for axis in range(2):
        i, pull = HIGH_ROWS[axis], pull_x if axis == 0 else pull_y
        out.value[i] += pull * at.phi[0]
        out.by_phi[i, 0] += pull
        out.by_parameters[i, 0] += _pulled(axis, -gravity * cosine, gravity * sine, at.phi)
        out.by_parameters[i, 1] += _pulled(axis, -gravity * sine, -gravity * cosine, at.phi)
    out.by_phi[0, 0] += pull_x
    out.by_phi[1, 0] += pull_y
    out.by_phi[2, 1] += pull_y
    out.by_phi[2, 2] -= pull_x


@compiled
def _pulled(i: int, x: float, y: float, phi: Array) -> float:
    """Part i of the wrench of a pull (x, y) per mass, in {b}, at the CoM."""
    if i == 0:
        return float(x * phi[0])
    if i == 1:
        return float(y * phi[0])
    return float(y * phi[1] - x * phi[2])
