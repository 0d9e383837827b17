"""The cart stands on all its wheels: each keeps a least load. See `cartgrasp.floor_reaction`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import FloorReaction

from .cart_limit import CartLimit, CartRows

if TYPE_CHECKING:
    from cartgrasp.model import CartModel
    from cartgrasp.motion import Motion


@final
@dataclass(frozen=True)
class TipOver(CartLimit):
    """`least_load` of each wheel, N."""

    least_load: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.least_load) and self.least_load >= 0):
            raise UsageError(f"tip-over: least_load: {self.least_load} is not a finite number >= 0, in N")

    def rows(self, cart: CartModel, motion: Motion | None, arms: Sequence[Arm]) -> CartRows:
        if np.linalg.matrix_rank(cart.wheel_set.positions - cart.wheel_set.positions.mean(axis=0), tol=1e-9) < 2:
            raise UsageError(f"tip-over: the wheels of {cart.name} stand in one line; three that don't are needed")
        floor = FloorReaction.of(cart, motion)
        names = tuple(f"wheel {i} load" for i in range(len(floor.load_offset)))
        return CartRows(
            of_sum=floor.load_map,
            of_arm=np.zeros((len(arms), len(names), 6)),
            low=self.least_load - floor.load_offset,
            high=np.full(len(names), np.inf),
            low_names=names,
            high_names=names,
        )
