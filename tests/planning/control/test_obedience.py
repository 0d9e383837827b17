"""An arm that gives little of what it is told is named; noise, and one that gives, are not."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import cartgrasp as cg
from cartgrasp.effects import ViscousDrag
from cartgrasp.simulation import SensorNoise
from planning import Controller, PathReference, chain, pause
from planning.control.obedience import LITTLE, LOUD, Obedience
from planning.references import speed_change

from .driving import ticks, without

CART = cg.CartModel(cg.Inertia(40.0, (0.3, 0.0), 3.0), effects=(ViscousDrag(linear=20.0, angular=2.0),))
PATH = PathReference(chain(speed_change(0.8, 0.5), pause(3.0), speed_change(-0.8, 0.5)))


@given(
    share=st.floats(-2.0, 2.0),
    size=st.floats(0.0, 100.0),
    steps=st.lists(st.floats(0.001, 0.05), min_size=60, max_size=60),
)
def test_a_steady_share_is_that_share(share, size, steps):
    """Whatever the rhythm: both means forget alike."""
    watched, told = Obedience(), np.array([size, 0.5 * size, 0.0, 1.0, 2.0, 3.0])
    for duration in steps:
        watched = watched.after({"left": told}, {"left": share * told}, duration)
    if watched.lasting >= 2.0 and np.linalg.norm(told[:3]) > 1.01 * LOUD:
        assert watched.idle == (pytest.approx({"left": share}) if share < LITTLE else {})
    if np.linalg.norm(told[:3]) < LOUD:
        assert not watched.idle


def run(lost, noise=1.0):
    """Steps; from 1.5 to 2.5 s the left arm gives nothing, and its sensor says so."""
    arms = [
        cg.Arm(n, [(-0.25, y, 1.0)], force_limit=(90.0,) * 3, moment_limit=(9.0,) * 3)
        for n, y in (("left", 0.2), ("right", -0.2))
    ]
    controller = Controller(CART, arms, PATH)

    def spoiled(felt, given):
        return without("left", felt, given) if lost and 1.5 <= felt.time < 2.5 else (felt, given)

    felt = SensorNoise(force=noise, moment=0.05 * noise)
    return [tick.step for tick in ticks(controller, CART, 4.0, felt, spoiled=spoiled)]


def test_a_lost_arm_is_named_and_the_cart_slows_down():
    steps = run(lost=True)
    named = [step.time for step in steps if step.idle]
    assert 1.5 < named[0] < 1.9
    assert named[-1] < 3.0
    assert {arm for step in steps for arm in step.idle} == {"left"}
    late = next(step for step in steps if step.time > 2.2)
    assert "left is felt to give " in late.words
    assert "slows to 50 % of its speed" in late.words
    assert all(np.isfinite(step.given.wrench_b).all() for step in steps)


@pytest.mark.parametrize("noise", [1.0, 5.0])
def test_arms_that_give_are_not_named(noise):
    assert not any(step.idle for step in run(lost=False, noise=noise))
