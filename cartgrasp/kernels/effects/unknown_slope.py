"""`effects/unknown_slope.py`: parameters grade_x, grade_y, moment_x, moment_y; the constant is gravity."""

from __future__ import annotations

import math

from ..jit import compiled
from ..situation import HIGH_ROWS, EffectValues, KernelSituation, Parts


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    _add(at, own, out, 0, (0, 1), 1.0)
    _add(at, own, out, 1, (1, 0), -1.0)
    _add(at, own, out, 2, (2, 3), 1.0)
    _add(at, own, out, HIGH_ROWS[0], (0, 1), 1.0)
    _add(at, own, out, HIGH_ROWS[1], (1, 0), -1.0)


@compiled
def _add(at: KernelSituation, own: EffectValues, out: Parts, i: int, of: tuple[int, int], sign: float) -> None:
    """Part i of the wrench: one parameter goes with the cosine of the heading, another, by a sign, with its sine."""
    mass, gravity, heading = at.phi[0], own.constants[0], at.pose[2]
    x, y = own.parameters[of[0]], sign * own.parameters[of[1]]
    cosine, sine = -gravity * math.cos(heading), -gravity * math.sin(heading)
    out.value[i] += mass * (cosine * x + sine * y)
    out.by_phi[i, 0] += cosine * x + sine * y
    out.by_pose[i, 2] += mass * (cosine * y - sine * x)
    out.by_parameters[i, of[0]] += mass * cosine
    out.by_parameters[i, of[1]] += sign * mass * sine
