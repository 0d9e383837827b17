"""A region of the floor that rolls harder: a carpet, a mat, gravel.

Each wheel drags `coefficient * load` more, along its own rolling (`rolling_resistance.py`), while it is in a
rectangle of the world. Its share inside is the product of four edges, each smoothed over `SMOOTHING_LENGTH`.

Carpet adds 0.012 in the mean to what wheelchairs have on linoleum (Hoffman et al., American Journal of Physical
Medicine & Rehabilitation 82, 2003, 880-889), and doubles what hard rubber has on concrete (`rolling_resistance.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from .compiled import WheelForce
from .effect import Gate, Parameter

SMOOTHING_LENGTH = 0.005
"""m: a wheel's share inside goes from 12 % to 88 % within twice this."""


@final
@dataclass(frozen=True)
class FloorPatch(WheelForce):
    """Extra rolling resistance between `x_min` and `x_max`, `y_min` and `y_max` (m, in {s})."""

    x_min: float = 0.0
    x_max: float = 0.0
    y_min: float = 0.0
    y_max: float = 0.0
    coefficient: float = 0.0

    name = "floor_patch"
    parameters = (
        Parameter("x_min", "m", typical=1.0, estimated=False),
        Parameter("x_max", "m", typical=1.0, estimated=False),
        Parameter("y_min", "m", typical=1.0, estimated=False),
        Parameter("y_max", "m", typical=1.0, estimated=False),
        Parameter("coefficient", "-", typical=0.03, lower=0.0, upper=1.0, is_by_mass=True),
    )
    gate = Gate.INSIDE
    signature = "drag that comes and goes at places of the floor, whatever the direction"
    constants = (SMOOTHING_LENGTH,)
    ordered = (("x_min", "x_max"), ("y_min", "y_max"))
