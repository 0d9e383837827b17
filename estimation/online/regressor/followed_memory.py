"""Memories of effects (casters' headings), which nobody measures, followed along a motion: at the mean and a deviation
to either side (sigma points; Julier and Uhlmann 1997). A caster that swings round forgets where it stood."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cartgrasp.effects.effect import TYPICAL_MEMORY_SPREAD
from cartgrasp.frames import Array, wrap_angle
from cartgrasp.model import CartModel

from ..kernels.row_algebra import Smoothed

MAX_MEMORY_STD_RATIO = 2.0
"""Standard deviation of a memory at first, and at most, in multiples of its spread: 1 rad for a caster."""


@dataclass(frozen=True)
class FollowedMemory:
    """The memory of a cart, with process noise `swivel` (rad/√s of a caster). `mean` and `std` (k,) are at the moment
    from which the motion goes on; `at` is None where nothing is known."""

    cart: CartModel
    swivel: float
    at: tuple[Array, Array] | None = None

    def along(self, moved: Smoothed, parameters: Array) -> Smoothed:
        """A motion with its memory, and how far that may be off."""
        if not self.cart.memory_names:
            return moved
        motion = moved.pose, moved.velocity, moved.time, parameters
        mean = self.cart.memory_along(*motion, None if self.at is None else self.at[0])
        std = MAX_MEMORY_STD_RATIO * self.cart.memory_spread if self.at is None else self.at[1]
        std = np.where(self.cart.memory_is_seen, 0.0, std)
        off = [wrap_angle(self.cart.memory_along(*motion, mean[0] + side * std) - mean) for side in (1.0, -1.0)]
        return moved._replace(memory=mean, memory_std=np.sqrt(0.5 * (off[0] ** 2 + off[1] ** 2)))

    def after(self, moved: Smoothed, k: int) -> FollowedMemory:
        """The memory followed up to the k-th moment of a motion with its memory."""
        if not self.cart.memory_names:
            return self
        spread, step = self.cart.memory_spread, float(moved.time[k] - moved.time[0])
        more = self.swivel**2 * step * (spread / TYPICAL_MEMORY_SPREAD) ** 2
        std = np.minimum(np.sqrt(moved.memory_std[k] ** 2 + more), MAX_MEMORY_STD_RATIO * spread)
        return FollowedMemory(self.cart, self.swivel, (moved.memory[k], std))

    @cached_property
    def mean(self) -> Array:
        """The mean (k,) of the memory; that of a cart at rest where nothing is known."""
        return self.cart.state()[self.cart.memory_slice] if self.at is None else self.at[0]

    def lost(self) -> FollowedMemory:
        return FollowedMemory(self.cart, self.swivel)
