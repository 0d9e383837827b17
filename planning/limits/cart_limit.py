"""What the hands together must obey: a CartLimit answers with rows over all arms' wrenches, each with names.

The block of arm i at contact p_i is `of_sum @ Ad_i(p_i) + of_arm[i]`, with Ad_i the spatial grasp map: rows over the
sum of what the hands do to the cart, about {b}'s origin, and over each hand's own wrench in {a}. So a block is affine
in its own contact and free of the others', which is what lets contact choice bound by it (duality.py).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, Self, final

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.checks import check_kind, shown
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import FloorReaction
from cartgrasp.frames import Array
from planning.quadratic_program import Cone

if TYPE_CHECKING:
    from cartgrasp.model import CartModel
    from cartgrasp.motion import Motion

MAX_CONE_FORCE = 1e6  # N, of a cone over contacts of hands without limits


NO_CONES = np.zeros((0, 1))


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
    """`low <= sum_i (of_sum @ Ad_i + of_arm[i]) F_i <= high`; of_sum (k, 6), of_arm (n, k, 6), low and high (k,), with
    infinity where there is no limit. `units` are the rows'; left out, N. The last rows are of cones, j each, with
    `cone_offsets` (c, j) and `cone_names`: they have no limits, and names only at the first of each.

    Certificates tell a name that ends in `upper` or `lower` with the limit's value and unit, and others alone."""

    of_sum: Array
    of_arm: Array
    low: Array
    high: Array
    low_names: tuple[str, ...]
    high_names: tuple[str, ...]
    cone_names: tuple[str, ...] = ()
    cone_offsets: Array = field(default_factory=lambda: NO_CONES)
    units: tuple[str, ...] = ()

    def checked(self, what: str, n_arms: int) -> Self:
        """Itself, where it is rows for so many arms."""
        k = np.size(self.low)
        for name, shape in {"of_sum": (k, 6), "of_arm": (n_arms, k, 6), "low": (k,), "high": (k,)}.items():
            values = getattr(self, name)
            if not isinstance(values, np.ndarray) or values.shape != shape or values.dtype.kind not in "fiu":
                found = f"of shape {values.shape}" if isinstance(values, np.ndarray) else shown(values)
                raise UsageError(f"{what}: {name} is {found}; for {k} rows and {n_arms} arms give an array {shape}")
        if not all(np.isfinite(values).all() for values in (self.of_sum, self.of_arm, self.cone_offsets)):
            raise UsageError(f"{what}: of_sum or of_arm has a number that is not finite; only low and high may be inf")
        if not ((self.low < np.inf).all() and (self.high > -np.inf).all()):
            raise UsageError(
                f"{what}: low and high have a number that is none; for no limit, give low -inf and high inf"
            )
        for i in np.flatnonzero(self.low > self.high)[:1].tolist():
            low, high = (f"{name} {side[i]:g}" for name, side in (("low", self.low), ("high", self.high)))
            raise UsageError(f"{what}: row {i}: {low} is above {high}, which no wrench obeys; give low up to high")
        n_plain = self.n_plain
        for name in ("low_names", "high_names"):
            names = getattr(self, name)
            if not isinstance(names, tuple) or len(names) != k or not all(names[:n_plain]):
                raise UsageError(f"{what}: {name}: {names!r} is not a name for each of {k} rows; name each, in a tuple")
        if not isinstance(self.units, tuple) or len(self.units) not in (0, k):
            raise UsageError(f"{what}: units: {self.units!r} is not a unit for each of {k} rows; leave them out for N")
        return self

    @classmethod
    def stacked(cls, parts: Sequence[CartRows], n_arms: int) -> Self:
        """All of them above each other, of which the last may have cones; none are no rows."""
        if not parts:
            return cls(np.zeros((0, 6)), np.zeros((n_arms, 0, 6)), np.zeros(0), np.zeros(0), (), ())
        if any(part.cone_names for part in parts[:-1]):
            raise UsageError("cart_limits: rows with cones stand before others; list that limit last")
        return cls(
            np.concatenate([part.of_sum for part in parts]),
            np.concatenate([part.of_arm for part in parts], axis=1),
            np.concatenate([part.low for part in parts]),
            np.concatenate([part.high for part in parts]),
            tuple([name for part in parts for name in part.low_names]),
            tuple([name for part in parts for name in part.high_names]),
            parts[-1].cone_names,
            parts[-1].cone_offsets,
            tuple([unit for part in parts for unit in part.each_unit]) if any(part.units for part in parts) else (),
        )

    @property
    def each_unit(self) -> tuple[str, ...]:
        """The unit of each row."""
        return self.units or ("N",) * len(self.low)

    @property
    def n_plain(self) -> int:
        """How many rows are of no cone; they come first."""
        return len(self.low) - self.cone_offsets.size

    @cached_property
    def cones(self) -> tuple[RowCone, ...]:
        starts = range(self.n_plain, len(self.low), self.cone_offsets.shape[1])
        return tuple(map(RowCone, self.cone_names, starts, self.cone_offsets))

    def over(self, grasp_maps: Array, owners: Array | None = None) -> Array:
        """Rows (..., k, 6) of each arm, or of the arms `owners`, at contacts with spatial grasp maps (..., 6, 6)."""
        return np.asarray(self.of_sum @ grasp_maps + (self.of_arm if owners is None else self.of_arm[owners]))

    def cones_over(self, matrix: Array, start: int, moved: tuple[Array, Array] | None = None) -> list[Cone]:
        """The cones over rows (k, unknowns), which stand at `start` in a program. Over a range these have a fixed part
        (k,), and a cone is wider by the most that their spread (k,) makes of it: of its axis, and of the length of the
        rest."""
        cones = []
        for cone in self.cones:
            offset = cone.offset
            if moved is not None:
                fixed_part, spread = (part[cone.own] for part in moved)
                offset = offset + fixed_part
                offset[0] += min(spread[0] + float(np.linalg.norm(spread[1:])), MAX_CONE_FORCE)
            cones.append(Cone(cone.name, matrix[cone.own], offset, start + cone.first))
        return cones

    def beside(self, wrench_b: Array) -> Self:
        """The same rows, where something else gives the cart a spatial wrench (6,) about {b}'s origin as well."""
        given = self.of_sum @ wrench_b
        of_cones = given[self.n_plain :].reshape(self.cone_offsets.shape)
        return replace(self, low=self.low - given, high=self.high - given, cone_offsets=self.cone_offsets + of_cones)

    def lifted(self) -> Self:
        """The same rows and cones, which limit nothing: of such a cone the width is any above 0."""
        of_sum, offsets, free = self.of_sum.copy(), np.zeros_like(self.cone_offsets), np.full(len(self.low), np.inf)
        of_sum[self.n_plain :], offsets[:, :1] = 0.0, 1.0
        return replace(self, of_sum=of_sum, low=-free, high=free, cone_offsets=offsets)

    def is_like(self, other: CartRows) -> bool:
        """Whether it has the same rows and cones, with other numbers."""
        return (self.low_names, self.high_names) == (other.low_names, other.high_names)

    def are_numbers(self, largest: float) -> bool:
        """Whether all are finite and none is larger, but for limits that aren't there."""
        values = np.concatenate([self.of_sum.ravel(), self.of_arm.ravel(), self.cone_offsets.ravel()])
        limits = np.concatenate([self.low, -self.high])
        are_limits = (np.abs(limits) <= largest) | (limits == -np.inf)
        return bool(np.abs(values).max(initial=0.0) <= largest and are_limits.all())


@dataclass(frozen=True, eq=False)
class PushedCart:
    """A cart as it is pushed now, at a time (s): the model that is believed, its motion, and the arms that push it.

    Before the first estimate `motion` is None, and the cart at rest. `motion.velocity` is nu (k,), its free velocities;
    `velocity_b` is the same in {b}."""

    cart: CartModel
    motion: Motion | None
    arms: Sequence[Arm]
    time: float = 0.0

    @cached_property
    def velocity_b(self) -> Array:
        """The planar velocity (3,) in {b}: forward and to the left (m/s), and the yaw rate (rad/s); zero at rest."""
        return np.zeros(3) if self.motion is None else self.cart.basis_b @ self.motion.velocity

    def by(self, arms: Sequence[Arm]) -> PushedCart:
        """By other arms; the floor is the same."""
        other = replace(self, arms=arms)
        other.__dict__.update({"floor": self.__dict__["floor"]} if "floor" in self.__dict__ else {})
        return other

    @cached_property
    def floor(self) -> FloorReaction:
        return FloorReaction.of(self.cart, self.motion, self.time)

    @cached_property
    def floor_with_partials(self) -> tuple[FloorReaction, Array]:
        return FloorReaction.with_partials(self.cart, self.motion, self.time)


class CartLimit(ABC):
    """Half-spaces of all hands' wrenches. They need not hold the zero wrench: a cart that is driven too fast round
    a bend skids unless the hands hold it. One whose rows depend on the cart's parameters is a `FloorLimit`."""

    looks_at_arms: ClassVar[bool] = True
    """Whether the rows depend on more of the arms than how many there are."""

    @abstractmethod
    def rows(self, pushed: PushedCart) -> CartRows:
        """The limit as it is now."""

    @final
    def checked_rows(self, pushed: PushedCart) -> CartRows:
        """`rows`, of which those of limits from outside are looked at: kernels look at none."""
        rows = self.rows(pushed)
        if not type(self).__module__.startswith(f"{__package__}."):
            what = f"cart_limits: {type(self).__name__}: rows"
            check_kind(what, rows, CartRows, "return CartRows(...)")
            rows.checked(what, len(pushed.arms))
        return rows


def cart_rows(limits: Sequence[CartLimit], pushed: PushedCart) -> CartRows:
    """All of them, above each other."""
    return CartRows.stacked([limit.checked_rows(pushed) for limit in limits], len(pushed.arms))
