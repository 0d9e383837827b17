"""What the fixed wheels bear from the side, whatever the floor's friction is: |lambda| <= bound, with lambda as `Skid`
has it. Wheel loads are not needed for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from cartgrasp.checks import MAX_FLOAT, number
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import n_loads

from .floor_limit import FloorLimit, FloorRows

if TYPE_CHECKING:
    from cartgrasp.model import CartModel

LOW, HIGH = ("side force to the right",), ("side force to the left",)


@final
@dataclass(frozen=True)
class SideForce(FloorLimit):
    """`bound` of what the floor pushes all fixed wheels together to either side, N."""

    bound: float

    def __post_init__(self) -> None:
        number("side force: bound", self.bound, 0.0, MAX_FLOAT, "give N")

    def on_floor(self, cart: CartModel) -> FloorRows:
        if cart.constraints.axle_x is None:
            raise UsageError(f"side force: {cart.name} has no fixed wheels to take it; add no_lateral_slip")
        mix, bound = np.eye(1, n_loads(cart) + 1, n_loads(cart)), np.array([self.bound])
        return FloorRows(mix, -bound, bound, LOW, HIGH)
