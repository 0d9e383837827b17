"""Carpets with soft edges, pushed over by two hands: one is named as one, two as two. The integrator is the tests'."""

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation import diagnose

from .runs import STEP, SUBSTEPS, record, reduced_rate

CART = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
EDGE, SECONDS = 0.08, 56.0
"""m: a carpet's share goes from 12 % to 88 % within twice this; s."""
FIRST, SECOND = (0.5, 1.3, 0.04), (2.2, 3.0, 0.06)
"""From and to (m, along x), and how much more it resists."""


def carpets_drag(state, carpets):
    soft = [(np.tanh((state[0] - low) / EDGE) - np.tanh((state[0] - high) / EDGE)) / 2 for low, high, _ in carpets]
    load = sum(more * share for share, (_, _, more) in zip(soft, carpets, strict=True))
    return CART[0] * 9.81 * load * np.tanh(state[3] / 0.002)


def there_and_back(time, state):
    """Feedback of the hands on speed and heading: 3.5 m along x, four times."""
    speed = 0.8 * np.sin(2 * np.pi * time / 14.0)
    heading = 0.25 * np.sin(0.9 * time)
    return 80.0 * (speed - state[3]), 40.0 * (heading - state[2]) - 25.0 * state[4]


def log_over(carpets, seed):
    state, states, wrenches = np.zeros(5), [], []
    for k in range(round(SECONDS / STEP)):
        fx, tau = there_and_back(k * STEP, state)
        states.append(state)
        wrenches.append([fx, tau])
        for _ in range(SUBSTEPS):
            middle = state + STEP / SUBSTEPS / 2 * reduced_rate(state, fx - carpets_drag(state, carpets), tau, CART)
            rate = reduced_rate(middle, fx - carpets_drag(middle, carpets), tau, CART)
            state = state + STEP / SUBSTEPS * rate
    hands, (forward, turning) = {}, np.transpose(wrenches)
    for name, side in (("left", 0.25), ("right", -0.25)):
        wrench = np.zeros((len(states), 6))
        wrench[:, 0] = forward / 2 - turning / (2 * side)
        hands[name] = (np.array([-0.4, side, 1.0]), wrench)
    return record(np.array(states), hands, (0.0005, 0.005, 0.5), seed)


@pytest.mark.long
@pytest.mark.parametrize(
    "carpets",
    [pytest.param((FIRST,), id="one"), pytest.param((FIRST, SECOND), id="two", marks=pytest.mark.prove)],
)
def test_as_many_patches_as_carpets(carpets):
    cart = CartModel(Inertia(22.0, (0.3, 0.04), 2.0), effects=(ViscousDrag(linear=4.0, angular=1.0),))
    found = diagnose(log_over(carpets, seed=5), cart)
    assert [effect.name for effect in found.effects] == ["floor_patch"] * len(carpets)
    told = sorted([effect.parameters[name][0] for name in ("x_min", "x_max")] for effect in found.effects)
    assert np.array(told) == pytest.approx(np.array(carpets)[:, :2], abs=0.1)
