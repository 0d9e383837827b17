"""What the wheels may bear, by their loads and by the lateral force lambda of the fixed ones on the axle (physics.md),

    lambda = m (u r + dx r' - dy r²) - fy,

where r' follows from the wrench. See `cartgrasp.floor_reaction`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from cartgrasp.checks import MAX_FLOAT, number
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import check_loads, n_loads

from .floor_limit import FloorLimit, FloorRows

if TYPE_CHECKING:
    from cartgrasp.model import CartModel

SKID_NAMES = ("skid to the right", "skid to the left")
SIDE_FORCE_NAMES = ("side force to the right",), ("side force to the left",)


@final
@dataclass(frozen=True)
class TipOver(FloorLimit):
    """The cart stands on all its wheels: each keeps `least_load`, N."""

    least_load: float = 0.0

    def __post_init__(self) -> None:
        number("tip-over: least_load", self.least_load, 0.0, MAX_FLOAT, "give N")

    def on_floor(self, cart: CartModel) -> FloorRows:
        if not cart.wheel_set.spans_floor:
            raise UsageError(f"tip-over: the wheels of {cart.name} stand in one line; three that don't are needed")
        check_loads(cart)
        n = len(cart.wheels)
        names = tuple(f"wheel {i} load" for i in range(n))
        return FloorRows(np.eye(n, n + 1), np.full(n, self.least_load), np.full(n, np.inf), names, names)


@final
@dataclass(frozen=True)
class Skid(FloorLimit):
    """The fixed wheels roll and don't skid: |lambda| <= `friction` · (their load)."""

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


@final
@dataclass(frozen=True)
class SideForce(FloorLimit):
    """What the fixed wheels bear together from either side, whatever friction is: |lambda| <= `bound`, N. It needs no
    wheel loads."""

    bound: float

    def __post_init__(self) -> None:
        number("side force: bound", self.bound, 0.0, MAX_FLOAT, "give N")

    def on_floor(self, cart: CartModel) -> FloorRows:
        if cart.constraints.axle_x is None:
            raise UsageError(f"side force: {cart.name} has no fixed wheels to take it; add no_lateral_slip")
        mix, bound = np.eye(1, n_loads(cart) + 1, n_loads(cart)), np.array([self.bound])
        return FloorRows(mix, -bound, bound, *SIDE_FORCE_NAMES)
