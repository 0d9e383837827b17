"""What is fed forward against a disturbance, up to how much, and when not."""

from __future__ import annotations

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.errors import UsageError
from cartgrasp.motion import Disturbance, Motion
from planning import Controller, PathReference, Rejection, chain, straight

CART = cg.CartModel(cg.Inertia(24.0, (0.3, 0.0), 2.0))
PATH = PathReference(chain(straight(2.0, 0.5)))


class Told:
    """At rest, pushed by what is told."""

    tells_disturbance = True

    def __init__(self, wrench, health="ok"):
        self.wrench, self.health = np.array(wrench), health

    def update(self, measurement):
        pushed = Disturbance(self.wrench, np.diag([4.0, 0.25]), acts=True)
        motion = Motion(np.zeros(3), np.zeros(2))
        return cg.Estimate(measurement.time, motion, {}, self.health, CART, CART.parameters, disturbance=pushed)


def given(estimator, **options):
    hands = [cg.Arm(name, [(-0.25, y, 1.0)], force_limit=(200,) * 3) for name, y in (("left", 0.2), ("right", -0.2))]
    step = Controller(CART, hands, PATH, estimator=estimator, regrasp=None, **options).step(cg.Measurement(0.0))
    return CART.basis_b.T @ step.given.wrench_b, step


def test_it_is_answered_by_as_much_up_to_a_limit():
    alone, _ = given(Told([0.0, 0.0]), rejection=None)
    pushed, step = given(Told([30.0, -4.0]))
    assert pushed - alone == pytest.approx([-30.0, 4.0])
    assert "something else pushes the cart" in step.words
    assert step.disturbance.words == "30 ± 2 N, −4 ± 0 N·m"
    assert "pushed by 30 ± 2 N" in repr(step.estimate)
    most, _ = given(Told([300.0, -40.0]), rejection=Rejection(force=50.0, moment=5.0))
    assert most - alone == pytest.approx([-50.0, 5.0])
    assert given(Told([30.0, -4.0]), rejection=None)[0] == pytest.approx(alone)


def test_nothing_is_answered_while_the_senses_are_lost():
    alone, _ = given(Told([0.0, 0.0], "stale"))
    assert given(Told([30.0, -4.0], "stale"))[0] == pytest.approx(alone)


def test_a_limit_is_a_number():
    with pytest.raises(UsageError, match="rejection: force"):
        Rejection(force=-1.0)
