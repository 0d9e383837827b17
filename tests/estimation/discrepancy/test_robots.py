"""What robots do to a log: a hand beside where it believes, a tool on its sensor, a tracker on another point; by the
integrator of `tests/effects/free_body.py`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.first_guess import FirstGuess
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.discrepancy import diagnose
from estimation.discrepancy.search.candidates import families
from tests.effects.free_body import STEP, driven, pushes, recorded
from tests.effects.test_pose_offset import tracked

CART, NO_TOOL, TOOL = (24.0, 0.3, 0.05, 2.0, 3.0, 1.0), (0.0, 0.0, 0.0, 0.0), (2.0, 0.05, 0.03, -0.04)
GUESS = CartModel(Inertia(22.0, (0.27, 0.0), 1.9), effects=(ViscousDrag(2.6, 1.1),))
SURE = replace(
    GUESS, inertia=Inertia(24.0, (0.3, 0.05), 2.0), first_guess=FirstGuess(known=("mass", "com_x", "com_y", "inertia"))
)
BEHIND, OTHER_END, BESIDE = (-0.25, 0.1, 1.0), (-0.25, -0.3, 1.0), (0.35, -0.3, 1.0)
NOISE = (0.0004, 0.005, 3.0, 0.1)


def log_of(tool=NO_TOOL, offset=(0.0, 0.0, 0.0), then=BEHIND, duration=24.0):
    """Of a hand that takes another place every 6 s, where one is given."""
    time = STEP * np.arange(round(duration / STEP))
    contacts = np.where(((time // 6) % 2 == 0)[:, None], BEHIND, then)
    given = pushes(time)
    states, _ = driven(given, CART, tool, contacts + np.array(offset))
    return recorded(states, contacts, given, NOISE)


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize("then", [BEHIND, OTHER_END])
def test_where_nothing_is_wrong_nothing_is_named(then):
    assert diagnose(log_of(then=then), GUESS).verdict == "no_discrepancy"


@pytest.mark.prove
def test_poses_6_cm_ahead_of_the_axle():
    (effect,) = diagnose(tracked(log_of(), np.array([0.06, 0.0]), 0.0), GUESS).effects
    assert effect.name == "pose_offset"
    value, std, _ = effect.parameters["x"]
    assert abs(value + 0.06) < 3 * std < 0.01
    assert effect.gap_share > 0.9


@pytest.mark.prove
def test_a_hand_6_cm_to_the_right():
    (effect,) = diagnose(log_of(offset=(0.0, -0.06, 0.0), then=BESIDE), GUESS).effects
    assert effect.name == "contact_offset"
    value, std, _ = effect.parameters["y"]
    assert abs(value + 0.06) < 3 * std < 0.03


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize(("guess", "then"), [(SURE, BEHIND), (GUESS, OTHER_END)], ids=["known cart", "regrasps"])
def test_a_tool_on_the_sensor(guess, then):
    (effect,) = diagnose(log_of(TOOL, then=then), guess).effects
    assert effect.name == "tool_inertia"
    value, std, _ = effect.parameters["mass"]
    assert abs(value - 2.0) < 3 * std < 0.9


@pytest.mark.long
def test_at_one_place_a_tool_is_another_cart():
    found = diagnose(log_of(TOOL), GUESS)
    assert found.verdict == "no_discrepancy"
    assert found.final.cart.inertia.mass == pytest.approx(26.0, abs=0.5)


def test_which_carts_may_have_them():
    """Where nobody pushes there is no sensor of wrenches, and where wheels forbid nothing no pose is seen to be off."""
    offered = {family.key for family in families(GUESS, ["left", "right"])}
    assert {"contact_offset.left", "tool_inertia.right", "pose_offset"} <= offered
    coasting = {family.key for family in families(GUESS, [])}
    assert "pose_offset" in coasting
    assert not any(key.startswith(("contact_offset", "tool_inertia")) for key in coasting)
    free = CartModel(GUESS.inertia, replace(GUESS.constraints, axle_x=None))
    assert "pose_offset" not in {family.key for family in families(free, ["hand"])}
