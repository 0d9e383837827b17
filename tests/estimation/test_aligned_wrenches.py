"""What aligning late wrenches by whole samples leaves to the batch fit."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import TimeDelay, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog
from cartgrasp.model import CartModel
from estimation.batch.wrench_regression import WrenchRegression

from .runs import simulate_two_hands

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
CART = CartModel(Inertia(20.0, (0.3, 0.0), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))


def late_log(samples, seed=0):
    """Of wrenches that are held over each step, and recorded so many samples later."""
    log = simulate_two_hands(TRUTH, seed, 20.0)
    arms = {n: ArmLog(a.contact, np.roll(a.wrench, samples, axis=0)) for n, a in log.arms.items()}
    return replace(log, arms=arms)


@pytest.mark.parametrize(("delay", "left"), [(0.024, -0.4), (0.026, 0.4), (0.03, 0.0)])
def test_what_alignment_leaves_is_usual(delay, left):
    regression = WrenchRegression(late_log(3), CART, None, True)
    told = regression.with_cart(CART.with_effect(TimeDelay(delay)))
    assert told.usual_delay[0] - regression.usual_delay[0] == pytest.approx(left / 2, abs=1e-3)
