"""The cart stands on all its wheels: each keeps a least load. See `cartgrasp.floor_reaction`."""

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


@final
@dataclass(frozen=True)
class TipOver(FloorLimit):
    """`least_load` of each wheel, N."""

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
