"""What is learned of laws that no name fits, from logs of the tests' own equations."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from cartgrasp.effects import LearnedForce, RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation import CartFilter, FilterNoise
from estimation.whole_log.identification import identify

from ..runs import STEP, SUBSTEPS, record, reduced_rate, weave

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.02)
LEVER, TURN = 0.27, 0.525
NOISE = (0.0004, 0.005, 1.0)


def flat_spot(_, state):
    """At the left wheel, of its way `state[5]`."""
    force = 6.0 * np.cos(2 * np.pi * state[5] / TURN) + 3.0 * np.sin(2 * np.pi * state[5] / TURN)
    return force, -LEVER * force


def breeze(time, state):
    """Along y of {s}, 5 N and 4 N more or less every 7 s."""
    blown = 5.0 + 4.0 * np.sin(2 * np.pi * time / 7.0)
    return np.sin(state[2]) * blown, 0.0


def crown(_, state):
    """A moment with the heading."""
    return 0.0, 1.5 * np.cos(2 * state[2]) - 0.8 * np.sin(2 * state[2])


LAWS = {
    "flat spot": (
        flat_spot,
        (LearnedForce("forward_force", "travelled_distance", lever=LEVER, period=TURN),),
        {"cos_1": 6.0, "sin_1": 3.0},
    ),
    "breeze": (
        breeze,
        (
            LearnedForce("world_force", "time", direction=np.pi / 2, label="mean"),
            LearnedForce("world_force", "time", direction=np.pi / 2, period=7.0, label="gusts"),
        ),
        {"mean.value_1": 5.0, "gusts.cos_1": 0.0, "gusts.sin_1": 4.0},
    ),
    "crown": (crown, (LearnedForce("yaw_moment", "heading", harmonics=(2,)),), {"cos_2": 1.5, "sin_2": -0.8}),
}
LAW_NAMES = pytest.mark.parametrize("name", LAWS)


def rate(time, state, wrench, law):
    fx, tau = law(time, state)
    motion = reduced_rate(state[:5], wrench[0] + fx, wrench[1] + tau, TRUTH)
    return np.append(motion, state[3] - LEVER * state[4])


@lru_cache(maxsize=2)
def pushed(name, duration=30.0, seed=1):
    """A log of a cart under a law, pushed by two hands with feedback."""
    law, state, states, wrenches = LAWS[name][0], np.zeros(6), [], []
    for k in range(round(duration / STEP)):
        wrench = weave(k * STEP, state)
        states.append(state[:5])
        wrenches.append(wrench)
        for j in range(SUBSTEPS):
            h, time = STEP / SUBSTEPS, k * STEP + j * STEP / SUBSTEPS
            k1 = rate(time, state, wrench, law)
            k2 = rate(time + h / 2, state + h / 2 * k1, wrench, law)
            k3 = rate(time + h / 2, state + h / 2 * k2, wrench, law)
            k4 = rate(time + h, state + h * k3, wrench, law)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    given, hands = np.array(wrenches), {}
    for hand, side in (("left", 0.25), ("right", -0.25)):
        wrench = np.zeros((len(given), 6))
        wrench[:, 0] = given[:, 0] / 2 - given[:, 1] / (2 * side)
        hands[hand] = (np.array([-0.4, side, 1.0]), wrench)
    return record(np.array(states), hands, NOISE, seed)


def guess(name):
    drags = ViscousDrag(linear=2.0, angular=1.0), RollingResistance(coefficient=0.015)
    return CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(*drags, *LAWS[name][1]))


def scores(name, parameters):
    """Errors over deviations of the law's amplitudes, and of the mass."""
    told = {f"learned_force.{key}": value for key, value in LAWS[name][2].items()} | {"mass": TRUTH[0]}
    return {key: (parameters[key].value - value) / parameters[key].std for key, value in told.items()}


@pytest.mark.long
@pytest.mark.some(1)
@LAW_NAMES
def test_identify_gives_the_amplitudes_back(name):
    found = identify([pushed(name)], guess(name))
    assert max(map(abs, scores(name, found.parameters).values())) < 4.0
    for key, value in LAWS[name][2].items():
        one = found.parameters[f"learned_force.{key}"]
        assert one.std < 0.5
        assert one.identifiable
        assert one.value == pytest.approx(value, abs=1.0)
    without = CartModel(guess(name).inertia, effects=guess(name).effects[:2])
    assert found.logs[0].noise_excess < 0.7 * identify([pushed(name)], without).logs[0].noise_excess


@pytest.mark.some(1)
@pytest.mark.long
@LAW_NAMES
def test_the_filter_learns_them_while_pushing(name):
    cart = guess(name)
    estimator = CartFilter(cart, ("left", "right"), noise=FilterNoise(0.0004, 0.0004, 0.005, 0.005, 1.0, 0.05))
    for row in pushed(name).measurements():
        estimator.update(row)
    last = estimator.estimate
    assert max(map(abs, scores(name, last.parameters).values())) < 4.5
    for key, value in LAWS[name][2].items():
        assert last.parameters[f"learned_force.{key}"].value == pytest.approx(value, abs=1.5)
