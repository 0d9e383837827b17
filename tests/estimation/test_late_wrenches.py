"""How late wrenches are, read off a log by the discrepancy workflow; what aligning by whole samples leaves."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import TimeDelay, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog
from cartgrasp.model import CartModel
from estimation.batch.wrench_regression import DELAY, WrenchRegression
from estimation.discrepancy.fitted import Fitted

from .runs import STEP, simulate_two_hands

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
CART = CartModel(Inertia(20.0, (0.3, 0.0), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))


def late_log(samples, seed=0):
    """Of wrenches that are held over each step, and recorded so many samples later."""
    log = simulate_two_hands(TRUTH, seed, 20.0)
    arms = {n: ArmLog(a.contact, np.roll(a.wrench, samples, axis=0)) for n, a in log.arms.items()}
    return replace(log, arms=arms)


@pytest.mark.parametrize("pairs", [False, True])
@pytest.mark.parametrize("samples", [2, 5])
def test_lateness_is_read_off_whatever_it_is_searched_from(samples, pairs):
    """What is held acts half a step after its row; of a log that may be of held or of sampled wrenches, a quarter is
    taken off."""
    fitted = Fitted((WrenchRegression(late_log(samples), CART, None, pairs),), CART)
    far = [fitted.with_added(TimeDelay(delay=(samples + off) * STEP)).listening() for off in (-1.6, 1.4)]
    found = [one.added[0].delay for one in far]
    assert found[0] == pytest.approx(found[1], abs=0.0015)
    assert np.mean(found) == pytest.approx((samples - 0.5 + DELAY) * STEP, abs=0.0025)


@pytest.mark.parametrize(("delay", "left"), [(0.024, -0.4), (0.026, 0.4), (0.03, 0.0)])
def test_what_alignment_leaves_is_usual(delay, left):
    regression = WrenchRegression(late_log(3), CART, None, True)
    told = regression.with_cart(CART.with_effect(TimeDelay(delay)))
    assert told.usual_delay[0] - regression.usual_delay[0] == pytest.approx(left / 2, abs=1e-3)


@pytest.mark.parametrize("pairs", [False, True])
def test_wrenches_that_come_late_fit_best_as_late(pairs):
    """Whether samples are looked at one by one or in pairs."""
    fitted = Fitted((WrenchRegression(late_log(3), CART, None, pairs),), CART)
    late = fitted.with_added(TimeDelay(delay=0.02)).listening()
    assert fitted.chi_squared() - late.chi_squared() > 100
