"""A floor whose slope nobody knows, in the form that an estimator needs: linear in what is not known.

With the `FloorSlope` `(gx, gy)`, gravity gives `-m g R(theta)ᵀ (gx, gy)` and, at the CoM d, the moment

    tau = -m g (cos(theta) hx + sin(theta) hy),    hx = dx gy - dy gx,    hy = -(dx gx + dy gy).

CoM times slope is not linear: while both are unknown, rows that are linear in them would tell of each other, wrongly
and in the same way each time. As numbers of their own, hx and hy are not: only that they belong together is not used.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from ..wheels import GRAVITY
from .compiled import CompiledForce
from .effect import Parameter


@final
@dataclass(frozen=True)
class UnknownSlope(CompiledForce):
    """Rise over run along the world's x and y, and the moments (per weight, m) that go with the heading's cosine and
    sine. It is in no vocabulary: who knows of a slope calls it `FloorSlope`."""

    grade_x: float = 0.0
    grade_y: float = 0.0
    moment_x: float = 0.0
    moment_y: float = 0.0

    name = "unknown_slope"
    parameters = (
        Parameter("grade_x", "-", typical=0.01, lower=-0.2, upper=0.2, is_by_mass=True),
        Parameter("grade_y", "-", typical=0.01, lower=-0.2, upper=0.2, is_by_mass=True),
        Parameter("moment_x", "m", typical=0.003, lower=-0.1, upper=0.1, is_by_mass=True),
        Parameter("moment_y", "m", typical=0.003, lower=-0.1, upper=0.1, is_by_mass=True),
    )
    signature = "a force and a moment that depend on heading, also at rest"
    constants = (GRAVITY,)
