"""The fixed wheels roll and don't skid: their lateral force stays within friction of what they carry (physics.md),

    |lambda| <= friction · (load of the fixed wheels),   lambda = m (u r + dx r' - dy r²) - fy on the axle,

where r' follows from the wrench. See `cartgrasp.floor_reaction`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from cartgrasp.checks import MAX_FLOAT, number
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import check_loads

from .floor_limit import FloorLimit, FloorRows

if TYPE_CHECKING:
    from cartgrasp.model import CartModel

SKID_NAMES = ("skid to the right", "skid to the left")


@final
@dataclass(frozen=True)
class Skid(FloorLimit):
    """`friction`: of the fixed wheels on the floor."""

    friction: float

    def __post_init__(self) -> None:
        number("skid: friction", self.friction, 0.0, MAX_FLOAT)

    def on_floor(self, cart: CartModel) -> FloorRows:
        fixed = ~cart.wheel_set.is_caster
        if cart.constraints.n_rows != 1 or not fixed.any():
            raise UsageError(f"skid: {cart.name} has no fixed wheels under one no_lateral_slip; only such a cart skids")
        check_loads(cart)
        mix = np.array([[*(-self.friction * fixed), side] for side in (1.0, -1.0)])
        return FloorRows(mix, np.full(2, -np.inf), np.zeros(2), SKID_NAMES, SKID_NAMES)
