"""A hand beside where the robot believes, by levers that are worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from cartgrasp.contacts import grasp_map_spatial
from cartgrasp.effects import ContactOffset, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation import CartFilter, FilterNoise, Prior
from estimation.whole_log.identification import identify
from estimation.whole_log.replay import replay
from tests.core.drawn import numbers, vectors

from .free_body import STEP, driven, pushes, recorded

CART, NO_TOOL = (24.0, 0.3, 0.05, 2.0, 3.0, 1.0), (0.0, 0.0, 0.0, 0.0)
CONTACT, OFFSET = np.array([-0.25, 0.1, 1.0]), np.array([0.02, -0.06, 0.0])
EFFECT = ContactOffset(*OFFSET[:2])
GUESS = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(2.0, 1.0),))
NOISE = (0.0004, 0.005, 3.0, 0.1)


@given(wrench=vectors(6, -80, 80), place=vectors(3, -1.0, 1.0), offset=vectors(2, -0.2, 0.2), yaw=numbers(-3.0, 3.0))
def test_it_acts_at_the_true_contact(wrench, place, offset, yaw):
    """What is recorded, at the believed contact, is not what acts; what is corrected, there, is."""
    effect = ContactOffset(*offset)
    c, s = np.cos(yaw), np.sin(yaw)
    there = place + np.array([c * offset[0] - s * offset[1], s * offset[0] + c * offset[1], 0.0])
    corrected = effect.corrected(wrench, effect.values).value
    at_true = grasp_map_spatial(there, yaw) @ wrench
    np.testing.assert_allclose(grasp_map_spatial(place, yaw) @ corrected, at_true, atol=1e-11)
    np.testing.assert_allclose(effect.recorded(corrected, effect.values), wrench, atol=1e-11)


def test_a_force_forwards_that_is_held_to_the_left_turns_the_cart_to_the_right():
    effect = ContactOffset(y=0.1)
    corrected = effect.corrected(np.array([10.0, 0, 0, 0, 0, 0]), effect.values).value
    np.testing.assert_allclose(corrected, [10.0, 0, 0, 0, 0, -1.0])


def log_of(duration=18.0):
    """Pushed at the true contact, told at the believed one; from half on the hand is on the other side."""
    time = STEP * np.arange(round(duration / STEP))
    contacts = np.where(time[:, None] < duration / 2, CONTACT, CONTACT * [1.0, -1.0, 1.0])
    given = pushes(time)
    states, _ = driven(given, CART, NO_TOOL, contacts + OFFSET)
    return recorded(states, contacts, given, NOISE)


@pytest.mark.long
def test_the_filter_and_identify_put_the_com_where_it_is():
    """Without it, it is as much too far to the left as the hand is to the right."""
    log, known = log_of(), Prior(known=frozenset({"contact_offset"}))
    noise = FilterNoise(*(NOISE[0],) * 2, *(NOISE[1],) * 2, *NOISE[2:])
    for told in (
        replay(log, CartFilter(GUESS.with_effect(EFFECT), ["hand"], noise=noise, prior=known)).last.parameters,
        identify([log], GUESS.with_effect(EFFECT), prior=known).parameters,
    ):
        for name, value in {"mass": 24.0, "com_x": 0.3, "com_y": 0.05}.items():
            assert abs(told[name].value - value) < 3 * told[name].std
    unaware = identify([log], GUESS).parameters["com_y"]
    assert unaware.value > 0.08


@pytest.mark.long
def test_a_known_cart_tells_where_the_hand_is():
    body = CartModel(Inertia(24.0, (0.3, 0.05), 2.0), effects=(ViscousDrag(3.0, 1.0), ContactOffset(x=0.02)))
    prior = Prior(known=frozenset({"mass", "com_x", "com_y", "inertia"}))
    found = identify([log_of()], body, prior=prior).parameters["contact_offset.y"]
    assert found.identifiable
    assert abs(found.value + 0.06) < 3 * found.std < 0.03
