"""Carts that no effect makes: why an extended model is none that anybody pushes."""

from __future__ import annotations

import numpy as np

from cartgrasp.effects import Effect, LoadSlosh
from cartgrasp.effects.effect import Gate
from cartgrasp.model import CartModel

DRIVEN, LEAST_POWER, NOWHERE = 0.15, 1e-6, 1e6
"""Of the most power that drags take, and in W: what they may give, at speeds of one sign, and be a mistake; m and s."""
INSTANT, LEAST_LEFT = 1e-6, 0.15
"""s; of its mass: what is left of a cart from which its load is taken."""
MOST_SWUNG = 2 / 3
"""Of its mass: a load that is nearly all of a cart does not swing on it, but it in the load."""


def takes_too_much(effect: Effect, cart: CartModel) -> str:
    if isinstance(effect, LoadSlosh) and effect.mass > MOST_SWUNG * cart.inertia.mass:
        return f"of {cart.inertia.mass:.3g} kg, {effect.mass:.3g} kg would swing"
    if effect.gate is not Gate.FROM:
        return ""
    began = float(effect.values[0])
    before, after = (float(cart.phi_at(time)[0]) for time in (began - INSTANT, began + INSTANT))
    return f"of {before:.3g} kg, it would leave {after:.3g} kg" if after < LEAST_LEFT * before else ""


def drives_itself(cart: CartModel, fastest: float) -> str:
    """Why no cart is like this that needs to be held back; headings, far from any place and time, are averaged over."""
    headings = np.linspace(0, 2 * np.pi, 4, endpoint=False)
    pose = np.column_stack([np.full(4, NOWHERE), np.full(4, NOWHERE), headings])
    still = np.zeros((4, cart.constraints.n_free))
    power = []
    for speed in fastest * np.array([-1.0, -0.5, 0.5, 1.0]):
        velocity = still.copy()
        velocity[:, 0] = speed
        state = np.hstack([pose, velocity, np.zeros((4, len(cart.memory_names)))])
        state[:, cart.memory_slice] = cart.settled_memory(state, np.tile(cart.parameters, (4, 1)), NOWHERE)
        power.append(speed * float(cart.required_wrench(state, still, time=NOWHERE)[:, 0].mean()))
    backward = min(power) < -max(DRIVEN * max(np.abs(power)), LEAST_POWER)
    return "with it, the cart would drive itself" if backward else ""
