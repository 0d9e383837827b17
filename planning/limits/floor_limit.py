"""Limits of what the floor gives the cart: wheels' loads, and the side force of its fixed wheels.

Each states how its rows add these up, so they are affine in the hands' wrenches and in what is known of the cart: the
margins of `robust.py` rest on that.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Self, final

import numpy as np

from cartgrasp.checks import check_kind
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import FloorReaction, n_loads
from cartgrasp.frames import Array

from .cart_limit import CartLimit, CartRows, PushedCart

if TYPE_CHECKING:
    from cartgrasp.model import CartModel


@dataclass(frozen=True, eq=False)
class FloorRows:
    """`low <= mix @ (loads, lateral force) <= high`, N: `mix` (k, n + 1) over the loads of n wheels, those that the
    cart tells (`floor_reaction.n_loads`), and the lateral force; low and high (k,)."""

    mix: Array
    low: Array
    high: Array
    low_names: tuple[str, ...]
    high_names: tuple[str, ...]

    def checked(self, what: str, n_loads: int) -> Self:
        """Itself, where it is rows for a cart that tells so many loads."""
        k = len(self.low)
        shapes = np.shape(self.mix), np.shape(self.low), np.shape(self.high), len(self.low_names), len(self.high_names)
        if shapes != ((k, n_loads + 1), (k,), (k,), k, k):
            form = (
                f"mix (k, {n_loads + 1}), of {n_loads} loads and the lateral force, low and high (k,), and k names each"
            )
            raise UsageError(f"{what}: its rows on the floor are of shapes {shapes}; give {form}")
        if not np.isfinite(self.mix).all() or np.isnan(self.low).any() or np.isnan(self.high).any():
            raise UsageError(f"{what}: its rows on the floor have a number that is none; for no limit, give inf")
        if not (all(self.low_names) and all(self.high_names)):
            raise UsageError(f"{what}: its rows on the floor have an empty name; name each, as plans tell them")
        return self

    @classmethod
    def stacked(cls, parts: Sequence[FloorRows], n_loads: int) -> Self:
        """All of them above each other; none are no rows."""
        if not parts:
            return cls(np.zeros((0, n_loads + 1)), np.zeros(0), np.zeros(0), (), ())
        return cls(
            np.concatenate([part.mix for part in parts]),
            np.concatenate([part.low for part in parts]),
            np.concatenate([part.high for part in parts]),
            tuple([name for part in parts for name in part.low_names]),
            tuple([name for part in parts for name in part.high_names]),
        )

    def under(self, floor: FloorReaction, n_arms: int) -> CartRows:
        """As rows over the hands' wrenches, for what the floor gives now."""
        rows = self.mix @ floor.rows
        offset = rows[:, 6]
        return CartRows(
            rows[:, :6],
            np.zeros((n_arms, len(rows), 6)),
            self.low - offset,
            self.high - offset,
            self.low_names,
            self.high_names,
        )


class FloorLimit(CartLimit):
    """Half-spaces of wheels' loads and the lateral force."""

    looks_at_arms: ClassVar[bool] = False

    @abstractmethod
    def on_floor(self, cart: CartModel) -> FloorRows:
        """The rows for a cart of such a structure, whatever its numbers are."""

    @final
    def rows(self, pushed: PushedCart) -> CartRows:
        return self.checked_on_floor(pushed.cart).under(pushed.floor, len(pushed.arms))

    @final
    def checked_on_floor(self, cart: CartModel) -> FloorRows:
        """`on_floor`, of which limits from outside are looked at."""
        what, rows = type(self).__name__, self.on_floor(cart)
        check_kind(f"{what}: its rows on the floor", rows, FloorRows, "return FloorRows(...)")
        return rows.checked(what, n_loads(cart))
