"""The cart stands on all its wheels: each keeps a least load. See `cartgrasp.floor_reaction`."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import ClassVar, final

import numpy as np

from cartgrasp.checks import LARGEST_FLOAT, number
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import check_loads

from .cart_limit import CartLimit, CartRows, Pushed


@final
@dataclass(frozen=True)
class TipOver(CartLimit):
    """`least_load` of each wheel, N."""

    least_load: float = 0.0

    looks_at_arms: ClassVar[bool] = False
    takes_many: ClassVar[bool] = True

    def __post_init__(self) -> None:
        number("tip-over: least_load", self.least_load, 0.0, LARGEST_FLOAT, "give N")

    def rows(self, pushed: Pushed) -> CartRows:
        if not pushed.cart.wheel_set.spans_floor:
            raise UsageError(
                f"tip-over: the wheels of {pushed.cart.name} stand in one line; three that don't are needed"
            )
        check_loads(pushed.cart)
        floor = pushed.floor
        names = _names(floor.load_offset.shape[-1])
        return CartRows(
            of_sum=floor.load_map,
            of_arm=np.zeros((len(pushed.arms), len(names), 6)),
            low=self.least_load - floor.load_offset,
            high=np.full(len(names), np.inf),
            low_names=names,
            high_names=names,
        )


@cache
def _names(n_wheels: int) -> tuple[str, ...]:
    return tuple(f"wheel {i} load" for i in range(n_wheels))
