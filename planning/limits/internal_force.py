"""Hands on a common handle don't work against each other along it: with a_i = axis · f_i the force of hand i along
the handle, in {b},

    |a_i - mean of all a_j| <= bound.

For two hands that is half of a_1 - a_2: forces that cancel on the cart and press the handle together or pull it
apart. Hands that don't stand in one line have a part of it in common with what turns the cart.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.checks import MAX_FLOAT, number, numbers
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array, rotation_z

from .cart_limit import CartLimit, CartRows, PushedCart

HANDLE_AXIS_B = (0.0, 1.0, 0.0)


@final
@dataclass(frozen=True)
class InternalForce(CartLimit):
    """`bound` in N, along `axis` in {b}: the handle's direction, of any length."""

    bound: float
    axis: tuple[float, float, float] = HANDLE_AXIS_B

    def __post_init__(self) -> None:
        number("internal force: bound", self.bound, 0.0, MAX_FLOAT, "give N")
        object.__setattr__(self, "axis", direction_b("internal force: axis", self.axis))

    def rows(self, pushed: PushedCart) -> CartRows:
        arms = pushed.arms
        departures = departures_along(self.axis, arms)
        if len(arms) <= 2:
            departures = departures[: len(arms) - 1]  # the second says the same
        k = len(departures)
        names = [f"internal force of {arm.name}" for arm in arms[:k]]
        return CartRows(
            of_sum=np.zeros((k, 6)),
            of_arm=departures.transpose(1, 0, 2),
            low=np.full(k, -self.bound),
            high=np.full(k, self.bound),
            low_names=tuple(f"{name} lower" for name in names),
            high_names=tuple(f"{name} upper" for name in names),
        )


def direction_b(what: str, axis: Sequence[float]) -> tuple[float, ...]:
    """An axis in {b}, of any length but 0."""
    found = numbers(what, axis, "(x, y, z) in {b}", -MAX_FLOAT, MAX_FLOAT)
    if not any(found):
        raise UsageError(f"{what}: {tuple(axis)} is not a direction (x, y, z) in {{b}}")
    return found


def departures_along(axis: Sequence[float], arms: Sequence[Arm]) -> Array:
    """D (n, n, 6): along an axis of {b}, hand i departs by `sum_j D[i, j] @ F_j` from the mean of all hands."""
    direction, n = np.asarray(axis) / np.abs(axis).max(), len(arms)
    direction = direction / np.linalg.norm(direction)
    along = np.zeros((n, 6))
    along[:, :3] = [direction @ rotation_z(arm.yaw) for arm in arms]
    return np.asarray((np.eye(n) - 1.0 / n)[:, :, None] * along)
