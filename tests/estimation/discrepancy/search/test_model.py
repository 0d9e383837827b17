"""What is met once, and what a motion meets again; and how late each arm's wrenches are."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cartgrasp.effects import ExternalPush, FloorPatch, ForceBias, PayloadChange, TimeDelay, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog
from cartgrasp.model import CartModel
from cartgrasp.wheels import Wheel
from estimation.discrepancy.search.model import Model
from estimation.discrepancy.search.scored_candidates import ScoredCandidate
from estimation.weak_form.balances import Balances

from ...runs import STEP, simulate_two_hands

PATCH = FloorPatch(x_min=1.0, x_max=1.5, y_min=-1.0, y_max=1.0, coefficient=0.1)
ON = np.linspace(0.0, 3.0, 301)


def met_once(effect, *ways):
    """By a cart with one wheel at {b}'s origin, on logs that go along x so."""
    cart = CartModel(Inertia(20.0, (0.0, 0.0), 2.0), wheels=(Wheel("fixed", 0.0, 0.0),))
    logs = [SimpleNamespace(motion=SimpleNamespace(pose=np.pad(x[:, None], ((0, 0), (0, 2))))) for x in ways]
    return Model.acts_once(SimpleNamespace(logs=logs, cart=cart), effect)


@pytest.mark.parametrize(
    ("ways", "is_once"),
    [
        ((ON,), True),
        ((ON, ON[:50]), True),
        ((ON[:50],), True),
        ((ON, ON), False),
        ((np.append(ON, ON[::-1]),), False),
        ((np.append(ON[120:], ON[::-1]),), False),
    ],
)
def test_a_patch_is_met_as_often_as_the_wheel_comes_onto_it(ways, is_once):
    assert met_once(PATCH, *ways) == is_once


def test_a_push_is_over_and_a_load_stays():
    assert met_once(ExternalPush(1.0, 2.0, 10.0), ON, ON)
    assert not met_once(PayloadChange(1.0, 5.0), ON)
    assert not met_once(ForceBias(1.0), ON)


@pytest.mark.parametrize(
    ("forms", "drift", "own"), [(None, None, 30.0), (20.0, None, 20.0), (20.0, 5.0, 5.0), (None, 40.0, 30.0)]
)
def test_what_is_accepted_gains_enough_beside_forms_and_drift(forms, drift, own):
    assert ScoredCandidate(PATCH, 30.0, 1, beside_forms=forms, beside_drift=drift).own_gain == own


def left_is_late(rows):
    """A log without noise of two hands, of which the left one's sensor is so many rows late."""
    log = simulate_two_hands((24.0, 0.28, 0.03, 2.2, 3.0, 1.2, 0.0), duration=15.0, noise=(0.0, 0.0, 0.0))
    arm = log.arms["left"]
    from_row = np.clip(np.arange(len(log)) - rows, 0, len(log) - 1)
    return replace(log, arms={**log.arms, "left": ArmLog(arm.contact, arm.wrench[from_row])})


@pytest.mark.parametrize("is_refitted", [False, True])
def test_an_arm_is_as_late_as_its_own_sensor(is_refitted):
    """And not as the latest arm's: a cart file that told one arm's delay had been told to lack something."""
    cart = CartModel(Inertia(24.0, (0.28, 0.03), 2.2), effects=(ViscousDrag(3.0, 1.2),))
    late = cart.with_effect(TimeDelay(8 * STEP, label="left"))
    model = Model.started([Balances.of(left_is_late(8), cart if is_refitted else late)], cart if is_refitted else late)
    model = model.refitted(late)
    sound = Model.started([Balances.of(left_is_late(0), cart)], cart)
    inner = slice(50, -50)
    both = [one.logs[0].wrenches.planar(cart)[inner] for one in (model, sound)]
    assert both[0] == pytest.approx(both[1], abs=1e-6)
    assert model.wrench_delay == 8 * STEP
    assert model.cart.inertia.mass == pytest.approx(24.0, abs=0.1)
