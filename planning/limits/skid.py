"""The fixed wheels roll and don't skid: their lateral force stays within friction of what they carry (physics.md),

    |lambda| <= friction · (load of the fixed wheels),   lambda = m (u r + dx r' - dy r²) - fy on the axle,

where r' follows from the wrench. See `cartgrasp.floor_reaction`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from cartgrasp.checks import LARGEST_FLOAT, number
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import check_loads

from .cart_limit import CartLimit, CartRows, Pushed

NAMES = ("skid to the right", "skid to the left")
SIDES, NO_LOW = np.array([1.0, -1.0]), np.full(2, -np.inf)


@final
@dataclass(frozen=True)
class Skid(CartLimit):
    """`friction`: of the fixed wheels on the floor."""

    friction: float

    looks_at_arms: ClassVar[bool] = False
    takes_many: ClassVar[bool] = True

    def __post_init__(self) -> None:
        number("skid: friction", self.friction, 0.0, LARGEST_FLOAT)

    def rows(self, pushed: Pushed) -> CartRows:
        cart = pushed.cart
        fixed = ~cart.wheel_set.is_caster
        if cart.constraints.n_rows != 1 or not fixed.any():
            raise UsageError(f"skid: {cart.name} has no fixed wheels under one no_lateral_slip; only such a cart skids")
        check_loads(cart)
        floor, share = pushed.floor, self.friction * fixed
        return CartRows(
            of_sum=SIDES[:, None] * floor.lateral_map[..., None, :] - (share @ floor.load_map)[..., None, :],
            of_arm=np.zeros((len(pushed.arms), 2, 6)),
            low=NO_LOW,
            high=(floor.load_offset @ share)[..., None] - SIDES * np.asarray(floor.lateral_offset)[..., None],
            low_names=NAMES,
            high_names=NAMES,
        )
