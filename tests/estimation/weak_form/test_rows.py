"""What rows are whitened by: where dry friction is known least, and how much forms and white noise explain."""

import numpy as np
import pytest

from cartgrasp.effects import RollingResistance, WheelDragImbalance
from cartgrasp.model import CartModel
from cartgrasp.wheels import Wheel
from estimation.weak_form.balances import Balances
from estimation.weak_form.rows import REST_SPEED, Errors, excess_noise, model_error

from .motions import TRUE, cart_of, noisy, weaving

TRACK = (Wheel("fixed", 0.0, 0.3), Wheel("fixed", 0.0, -0.3))


@pytest.fixture(scope="module")
def balances():
    return Balances.of(noisy(weaving(TRUE, 20.0), 3), cart_of(TRUE))


def with_effect(effect):
    cart = cart_of(TRUE)
    return CartModel(cart.inertia, cart.constraints, (*cart.effects, effect), TRACK)


def test_a_wheel_that_stands_drags_nobody_knows_which_way(balances):
    """A right wheel that drags alone, by 10 N at a lever of 0.3 m: where it rolls at less than a fifth of `REST_SPEED`,
    nearly all of that is open, whatever the cart does; where it rolls fast, and no caster turns round, next to
    nothing."""
    motion = balances.motion
    whole = with_effect(WheelDragImbalance(10.0, -3.0))
    bare = with_effect(WheelDragImbalance(0.0, 0.0))
    more = np.sqrt(np.maximum(model_error(balances, whole)[1] ** 2 - model_error(balances, bare)[1] ** 2, 0.0))
    rolls = np.abs(motion.velocity[:, 0] + 0.3 * motion.velocity[:, 1])
    stands, fast = rolls < REST_SPEED / 5, (rolls > 8 * REST_SPEED) & (np.abs(motion.velocity[:, 0]) > 0.4)
    assert stands.any()
    assert fast.any()
    assert (more[stands, 0] > 7.0).all()
    assert (more[stands, 1] > 2.0).all()
    away = fast & (
        motion.way - np.maximum.accumulate(np.where(np.abs(motion.velocity[:, 0]) < 0.02, motion.way, 0)) > 1
    )
    assert (more[away] < 0.05 * np.array([10.0, 3.0])).all()


def told_of(balances, excess, form, friction):
    """What is told of rows whose noise is so large: excess, form and friction (2,) of the free directions."""
    cart = with_effect(RollingResistance(0.03))
    errors, count = Errors.of(balances, cart), balances.n_balances(cart)
    k, random = len(balances.used), np.random.default_rng(0)
    white = random.standard_normal((k, count))
    sizes = (
        np.append(np.full(2, size), np.full(count - 2, least))
        for size, least in zip((excess, form, friction), LEAST, strict=True)
    )
    unit = errors.whitening(*sizes)(np.tile(np.eye(k)[:, None, :], (1, count, 1)))
    left = np.column_stack([np.linalg.solve(unit[:, i], white[:, i]) for i in range(count)])
    return [one[:2] for one in excess_noise([(errors, left)], 0.0)]


LEAST = 1e-6, 0.02, 0.02


def test_forms_explain_no_more_than_there_is(balances):
    """Rows with the sensors' noise alone leave next to nothing for what forms may be wrong by; forces that no sensor
    made are told as white noise of their density."""
    excess, form, _ = told_of(balances, 1e-6, 0.02, 1.0)
    assert (form < 0.25).all()
    assert (excess < 0.5).all()
    excess, form, _ = told_of(balances, np.array([20.0, 5.0]), 1.0, 1.0)
    assert excess == pytest.approx([20.0, 5.0], rel=0.2)
    assert form == pytest.approx(1.0)


@pytest.mark.parametrize("true", [0.02, 0.3, 1.0])
def test_rows_tell_how_wrong_friction_is_near_standstill(balances, true):
    """To a factor of two: they are a few, and some count as if it were as wrong as it may be."""
    _, _, friction = told_of(balances, 1e-6, 0.02, true)
    assert (friction > true / 2).all()
    assert (friction < max(2 * true, 0.3)).all()
