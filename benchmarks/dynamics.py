"""A cart's dynamics with all partials."""

from __future__ import annotations

import numpy as np

from cartgrasp import CartModel, Inertia
from cartgrasp.effects import RollingResistance, ViscousDrag
from cartgrasp.kernels.entries import rates
from cartgrasp.studies.shopping_cart import WHEELS, loaded_cart

from .measuring import Competitor, interleave
from .report import Result, timed_table

BURST = 20
STACK = 1000
OURS = "CartModel.rate, 2 effects"
NOTE = f"""Viscous drag and rolling resistance on four wheels; the loaded cart has swivel friction too. `rate` and
`inverse` give values and partials by state, wrench or acceleration, and parameters. A stack of {STACK:,} shows what one
state costs inside compiled code, which is what simulation and estimator pay."""


def run(rounds: int) -> Result:
    two = CartModel(
        Inertia(24.0, (0.36, 0.05), 2.0), effects=(ViscousDrag(3.0, 1.2), RollingResistance(0.02)), wheels=WHEELS
    )
    loaded = loaded_cart()
    competitors = {
        OURS: _rate(two),
        "CartModel.rate, loaded cart": _rate(loaded),
        "CartModel.inverse, 2 effects": _inverse(two),
        "CartModel.inverse, loaded cart": _inverse(loaded),
    }
    stacks = {"rates, 2 effects": _inside(two), "rates, loaded cart": _inside(loaded)}
    one = timed_table("One state", interleave(competitors, rounds, BURST), OURS, "µs", {})
    many = timed_table(f"A stack of {STACK:,} states", interleave(stacks, rounds), "rates, 2 effects", "µs", {})
    return Result("Dynamics", NOTE, (one, many))


def _rate(cart: CartModel) -> Competitor:
    state, wrench_b = cart.state((0.1, 0.2, 0.3), [0.5, 0.1]), np.array([15.0, 0.0, 1.0])
    return lambda _: cart.rate(state, wrench_b)


def _inverse(cart: CartModel) -> Competitor:
    state, acceleration = cart.state((0.1, 0.2, 0.3), [0.5, 0.1]), np.array([0.3, 0.2])
    return lambda _: cart.inverse(state, acceleration)


def _inside(cart: CartModel) -> Competitor:
    state, dynamics = cart.state((0.1, 0.2, 0.3), [0.5, 0.1]), cart.dynamics
    row = np.concatenate([state, [0.0], cart.parameters, [15.0, 0.0, 1.0], np.ones(2), np.zeros(2)])
    n = len(state)
    given, found = np.tile(row, (STACK, 1)), np.empty((STACK, n * (4 + n + len(cart.parameters))))
    return lambda _: rates(dynamics.floats, dynamics.ints, given, found)
