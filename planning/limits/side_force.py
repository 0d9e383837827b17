"""What the fixed wheels bear from the side, whatever the floor's friction is: |lambda| <= bound, with lambda as `Skid`
has it. Wheel loads are not needed for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from cartgrasp.checks import LARGEST_FLOAT, number
from cartgrasp.errors import UsageError

from .cart_limit import CartLimit, CartRows, Pushed

LOW, HIGH = ("side force to the right",), ("side force to the left",)


@final
@dataclass(frozen=True)
class SideForce(CartLimit):
    """`bound` of what the floor pushes all fixed wheels together to either side, N."""

    bound: float

    looks_at_arms: ClassVar[bool] = False
    takes_many: ClassVar[bool] = True

    def __post_init__(self) -> None:
        number("side force: bound", self.bound, 0.0, LARGEST_FLOAT, "give N")

    def rows(self, pushed: Pushed) -> CartRows:
        if pushed.cart.constraints.axle_x is None:
            raise UsageError(f"side force: {pushed.cart.name} has no fixed wheels to take it; add no_lateral_slip")
        floor = pushed.floor
        offset = np.asarray(floor.lateral_offset)[..., None]
        return CartRows(
            of_sum=floor.lateral_map[..., None, :],
            of_arm=np.zeros((len(pushed.arms), 1, 6)),
            low=-self.bound - offset,
            high=self.bound - offset,
            low_names=LOW,
            high_names=HIGH,
        )
