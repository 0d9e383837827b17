"""How much of what a body's parameters are regressed on is the noise of the motion.

Noise in what is regressed on pulls a parameter towards zero, by the share that it has in the squares of its column
(errors in variables). Where a cart does not turn, all of what inertia is regressed on is noise.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel

from .balances import Balances
from .fit import jacobian
from .rows import wrench_noise

MOST_NOISE = 0.1
"""Of a column's squares: more biases by more than a tenth what is regressed on it."""


def told_by_motion(logs: Sequence[Balances], cart: CartModel) -> np.ndarray:
    """Which coordinates of the body (4,) the motions of any of the logs tell, beyond their noise."""
    by = jacobian(cart)[:N_PHI, :N_PHI]
    parts = [_squares(balances, cart, by) for balances in logs if len(balances.used)]
    if not parts:
        return np.zeros(N_PHI, dtype=bool)
    whole, noise = np.sum(parts, axis=0)
    return np.asarray(noise < MOST_NOISE * whole)


def _squares(balances: Balances, cart: CartModel, by: Array) -> tuple[Array, Array]:
    """Of the rows' columns (4,), in units of the wrench's noise: all, and what the motion's noise makes of them."""
    motion, f = balances.motion, cart.constraints.n_free
    state, scale = balances.state(cart), wrench_noise(balances, cart)[:, None]
    own = [0, 1, 2] if f == 3 else [0, 2][:f]
    order = 2 if motion.noise.velocity is None else 1
    std = (motion.noise.pose if motion.noise.velocity is None else motion.noise.velocity)[own]

    def columns(state: Array, acceleration: Array) -> Array:
        slopes = cart.inverse(state, acceleration, time=motion.time).by_parameters
        return np.asarray(slopes[..., :N_PHI] @ by / scale)

    first, noise = columns(state, motion.acceleration), np.zeros(N_PHI)
    whole = (balances.integrated(first) ** 2).sum(axis=(0, 1))
    for i in range(f):
        unit, moved = np.zeros(f), state.copy()
        unit[i] = 1.0
        moved[:, cart.velocity_slice.start + i] += std[i]
        turned = (columns(state, motion.acceleration + unit) - first) * std[i]
        for change, derivatives in ((turned, order), (columns(moved, motion.acceleration) - first, order - 1)):
            each = (change**2).mean(axis=0).sum(axis=0) * balances.overlap(derivatives, 0) * balances.sample_step
            noise += each * len(balances.used)
    return whole, noise
