"""How a cart is brought to rest where no wrench keeps its limits."""

from __future__ import annotations

from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Motion

from ..tracking import wrench_as_it_moves

BRAKING_TIME_CONSTANT = 0.5
"""s: the time constant; after four of these, 2 s, 2 % of the velocity is left."""


def braking_wrench(
    model: CartModel, motion: Motion, time: float, share: float = 1.0, crept: Array | None = None
) -> Array:
    """The planar wrench (3,) in {b} under which velocities fade as they are, so that the cart stays on its curve:
    `nu' = -share nu / T` with T = `BRAKING_TIME_CONSTANT`. What it has `crept` (k,), m and rad, is held against by
    `crept / T²` more."""
    acceleration = -motion.velocity / BRAKING_TIME_CONSTANT
    if crept is not None:
        acceleration = acceleration - crept / BRAKING_TIME_CONSTANT**2
    return wrench_as_it_moves(model, motion, share * acceleration, time)
