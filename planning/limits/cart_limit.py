"""What the hands together must obey: a CartLimit answers with rows over all arms' wrenches, each with names.

The block of arm i at contact p_i is `of_sum @ Ad_i(p_i) + of_arm[i]`, with Ad_i the spatial grasp map: rows over the
sum of what the hands do to the cart, about {b}'s origin, and over each hand's own wrench in {a}. So a block is affine
in its own contact and free of the others', which is what lets contact choice bound by it (duality.py).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from typing import TYPE_CHECKING, Self

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.floor_reaction import FloorReaction
from cartgrasp.frames import Array

if TYPE_CHECKING:
    from cartgrasp.model import CartModel
    from cartgrasp.motion import Motion


@dataclass(frozen=True, eq=False)
class RowCone:
    """`offset` (j,) and the values of as many rows, from row `first` on, lie in the second-order cone."""

    name: str
    first: int
    offset: Array

    @property
    def own(self) -> slice:
        """The rows."""
        return slice(self.first, self.first + len(self.offset))


@dataclass(frozen=True, eq=False)
class CartRows:
    """`low <= sum_i (of_sum @ Ad_i + of_arm[i]) F_i <= high`; of_sum (k, 6), of_arm (n, k, 6), low and high (k,).
    Rows of `cones` have no limits, and names only at the first of each."""

    of_sum: Array
    of_arm: Array
    low: Array
    high: Array
    low_names: tuple[str, ...]
    high_names: tuple[str, ...]
    cones: tuple[RowCone, ...] = ()

    @classmethod
    def none(cls, n_arms: int) -> Self:
        return cls(np.zeros((0, 6)), np.zeros((n_arms, 0, 6)), np.zeros(0), np.zeros(0), (), ())

    def is_like(self, other: CartRows) -> bool:
        """Whether it has the same rows and cones, with other numbers."""
        return (self.low_names, self.high_names) == (other.low_names, other.high_names)

    def are_numbers(self, largest: float) -> bool:
        """Whether all are finite and none is larger, but for limits that aren't there."""
        limits = [part[~np.isinf(part)] for part in (self.low, self.high)]
        is_there = ~((self.low == np.inf) | (self.high == -np.inf)).any()
        parts = (self.of_sum, self.of_arm, *limits, *(cone.offset for cone in self.cones))
        return bool(is_there) and all(bool((np.abs(part) <= largest).all()) for part in parts)

    def __and__(self, other: CartRows) -> CartRows:
        behind = tuple(replace(cone, first=len(self.low) + cone.first) for cone in other.cones)
        return CartRows(
            np.vstack([self.of_sum, other.of_sum]),
            np.concatenate([self.of_arm, other.of_arm], axis=1),
            np.concatenate([self.low, other.low]),
            np.concatenate([self.high, other.high]),
            self.low_names + other.low_names,
            self.high_names + other.high_names,
            self.cones + behind,
        )


@dataclass(frozen=True, eq=False)
class Pushed:
    """What is pushed and by whom: a cart, its motion (at rest if None), and the arms. With `slope_of`, another and a
    direction (p,) of the cart's parameters, `floor` is the slope of that one's."""

    cart: CartModel
    motion: Motion | None
    arms: Sequence[Arm]
    slope_of: tuple[Pushed, Array] | None = None

    def along(self, direction: Array) -> Pushed:
        return replace(self, slope_of=(self, direction))

    @cached_property
    def floor(self) -> FloorReaction:
        if self.slope_of is None:
            return FloorReaction.of(self.cart, self.motion)
        pushed, direction = self.slope_of
        return pushed.floor_by_parameters.along(direction)

    @cached_property
    def floor_by_parameters(self) -> FloorReaction:
        return FloorReaction.by_parameters(self.cart, self.motion)


class CartLimit(ABC):
    """Half-spaces of all hands' wrenches. They need not hold the zero wrench: a cart that is driven too fast round
    a bend skids unless the hands hold it. The cart's parameters enter through `pushed.floor` alone, in whose numbers
    rows are affine: margins (robust.py) rest on that."""

    @abstractmethod
    def rows(self, pushed: Pushed) -> CartRows:
        """The limit as it is now."""


def cart_rows(limits: Sequence[CartLimit], pushed: Pushed) -> CartRows:
    """All of them, above each other."""
    return reduce(CartRows.__and__, (limit.rows(pushed) for limit in limits), CartRows.none(len(pushed.arms)))
