"""Fits in coordinates in which every cart is physical: first guesses don't matter, and nothing is impossible."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimation.discrepancy.search.model import Model
from estimation.weak_form.balances import Balances
from estimation.weak_form.coordinates import coordinates, jacobian, with_coordinates

from .motions import TRUE, cart_of, noisy, weaving

PLACE = st.floats(-1.0, 1.0)
LOGARITHM = st.floats(-5.0, 7.0)
DRAG = st.floats(0.1, 50.0)


@given(st.tuples(LOGARITHM, PLACE, PLACE, LOGARITHM, DRAG, DRAG))
def test_every_point_is_a_physical_cart(z):
    cart = with_coordinates(cart_of(TRUE), np.array(z))
    assert cart.inertia.mass > 0
    assert cart.inertia.about_com > 0
    assert cart.inertia.mass == pytest.approx(np.exp(z[0]))
    about_b = np.exp(z[3]) + np.exp(z[0]) * (z[1] ** 2 + z[2] ** 2)
    assert cart.inertia.phi[3] == pytest.approx(about_b)


@settings(max_examples=30, deadline=None)
@given(st.tuples(st.floats(1.0, 5.0), PLACE, PLACE, st.floats(-1.0, 3.0), DRAG, DRAG))
def test_coordinates_and_slopes(z):
    cart = with_coordinates(cart_of(TRUE), np.array(z))
    assert coordinates(cart) == pytest.approx(np.array(z), abs=1e-7)
    by = jacobian(cart)
    for i in range(len(z)):
        off = np.zeros(len(z))
        off[i] = 1e-5
        ends = [with_coordinates(cart, np.array(z) + sign * off).parameters for sign in (1, -1)]
        assert (ends[0] - ends[1]) / 2e-5 == pytest.approx(by[:, i], rel=1e-5, abs=1e-4)


@pytest.mark.parametrize("times", [1 / 3, 1.0, 3.0])
def test_a_first_guess_from_a_third_to_three_times(times):
    """Of mass and inertia; the log tells the mass to 0.2 %."""
    guess = cart_of((times * TRUE[0], 0.1, 0.0, times * TRUE[3], 2.0, 1.0))
    found = Model.started([Balances.of(noisy(weaving(TRUE, 30.0), 3), guess)], guess).cart
    assert found.inertia.mass == pytest.approx(TRUE[0], rel=0.01)
    assert found.inertia.com == pytest.approx(TRUE[1:3], abs=0.01)
    assert found.inertia.about_com == pytest.approx(TRUE[3], rel=0.05)


def test_drag_stops_at_its_bound():
    """A log that pushes the cart on by itself: drag can't be negative, and the body stays physical."""
    log = noisy(weaving((*TRUE[:4], -2.0, 0.0), 20.0), 5)
    guess = cart_of(TRUE)
    found = Model.started([Balances.of(log, guess)], guess).cart
    assert found.effects[0].linear >= 0.0
    assert found.effects[0].linear == pytest.approx(0.0, abs=1e-6)
    assert found.inertia.about_com > 0
