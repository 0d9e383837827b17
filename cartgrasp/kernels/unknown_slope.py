"""`effects/unknown_slope.py`: parameters grade_x, grade_y, moment_x, moment_y; the constant is gravity."""

from __future__ import annotations

import math

from .jit import compiled
from .situation import EffectValues, KernelSituation, Parts


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    mass, gravity = at.phi[0], own.constants[0]
    cosine, sine = -gravity * math.cos(at.pose[2]), -gravity * math.sin(at.pose[2])
    for i in range(3):
        # Along, across and about {b}: the part that goes with the cosine of the heading, and with its sine.
        of_cosine, of_sine = (0, 1) if i == 0 else (1, 0) if i == 1 else (2, 3)
        sign = -1.0 if i == 1 else 1.0
        x, y = own.parameters[of_cosine], sign * own.parameters[of_sine]
        out.value[i] += mass * (cosine * x + sine * y)
        out.by_phi[i, 0] += cosine * x + sine * y
        out.by_pose[i, 2] += mass * (cosine * y - sine * x)
        out.by_parameters[i, of_cosine] += mass * cosine
        out.by_parameters[i, of_sine] += sign * mass * sine
