"""A floor that is not level: gravity pulls at the CoM, so it also turns the cart.

With the height `h = grade · (x, y)` of the floor, the potential `m g h(CoM)` gives `-m g grade` in {s}, so

    f_b = -m g R(theta)ᵀ grade,    tau = m dx (f_b/m)_y - m dy (f_b/m)_x,

linear in m, m dx and m dy. The floor's angle is small: 1 - cos of it is left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from ..wheels import GRAVITY
from .compiled import CompiledForce
from .effect import Parameter


@final
@dataclass(frozen=True)
class FloorSlope(CompiledForce):
    """Rise over run along the world's x and y. Across a path for wheelchairs at most 0.02 is allowed (ADAAG)."""

    grade_x: float = 0.0
    grade_y: float = 0.0

    name = "floor_slope"
    parameters = (
        Parameter("grade_x", "-", typical=0.01, lower=-1.0, upper=1.0, is_by_mass=True),
        Parameter("grade_y", "-", typical=0.01, lower=-1.0, upper=1.0, is_by_mass=True),
    )
    signature = "a force that depends on heading, also at rest, and keeps its sign when the motion turns"
    constants = (GRAVITY,)
