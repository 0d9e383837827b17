"""Where a cart stands or turns back, and what may hold it there."""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..standstill import HALF_TRACK
from .balances import Balances
from .motion import KNOT_STEPS

GRAVITY = 9.81
HELD_WEIGHT_FRACTION = 0.1
"""Share of the weight that a hand or a chock holds at least."""
FRICTION_COEFFICIENT = 0.01
"""Half of a usual coefficient of rolling resistance."""
MIN_TURNING_SPEED = 1e-6
"""Least speed (m/s)."""
MAX_REVERSAL_TIME = 0.3
"""Longest moment (s): who turns back does not stand for as long."""


def holding_forces(balances: Balances, cart: CartModel) -> Array:
    """What holds a cart that stands for longer than a moment (n, f): anything may."""
    motion = balances.motion
    edges = np.flatnonzero(np.diff(np.r_[False, balances.turning_speed < balances.still_speed, False].astype(int)))
    found = np.zeros((len(motion.time), cart.constraints.n_free))
    total = balances.wrenches.planar(cart) @ cart.basis_b
    size = np.hypot(np.sqrt((total**2).mean(axis=0)), HELD_WEIGHT_FRACTION * GRAVITY * cart.inertia.mass)
    for first, last in edges.reshape(-1, 2):
        if (last - first) * motion.step > MAX_REVERSAL_TIME:
            found[first:last] = size
    return found


def reversal_drag_errors(balances: Balances, cart: CartModel) -> Array:
    """What drags may be off by (n, f) where a cart turns back: nobody sees when exactly they change their sign."""
    motion, free = balances.motion, cart.constraints.n_free
    unseen = np.abs(motion.acceleration[:, 0]) * KNOT_STEPS * motion.step / 2 + motion.rate_std[:2].max()
    turning = np.exp(-((motion.velocity[:, 0] / np.maximum(unseen, MIN_TURNING_SPEED)) ** 2))
    levers = np.array([1.0, 1.0, HALF_TRACK][:: 1 if free == 3 else 2][:free])
    return np.asarray(FRICTION_COEFFICIENT * GRAVITY * cart.inertia.mass * turning[:, None] * levers)
