"""A slope in the form that an estimator needs, against the slope itself, and its partials against differences."""

import numpy as np
from hypothesis import given

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import FloorSlope, UnknownSlope
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from tests.core.differences import assert_partials
from tests.core.drawn import numbers, phis, poses, vectors, velocities

CASTERS = RollingConstraints(axle_x=None)


def cart(phi, effect):
    return CartModel(Inertia.from_phi(phi), CASTERS, (effect,))


@given(phis(), numbers(-0.04, 0.04), numbers(-0.04, 0.04), poses(), velocities())
def test_with_moments_of_the_com_it_is_the_slope(phi, grade_x, grade_y, pose, velocity):
    """With `hx = dx gy - dy gx` and `hy = -(dx gx + dy gy)`, derived by hand from the moment of gravity at the CoM."""
    dx, dy = phi[1:3] / phi[0]
    own = UnknownSlope(grade_x, grade_y, dx * grade_y - dy * grade_x, -(dx * grade_x + dy * grade_y))
    state = np.concatenate([pose, velocity])
    expected = cart(phi, FloorSlope(grade_x, grade_y)).effect_wrench(state)
    np.testing.assert_allclose(cart(phi, own).effect_wrench(state), expected, atol=1e-9 * (1.0 + abs(phi).max()))


@given(phis(), vectors(4, -0.1, 0.1), poses(), velocities())
def test_partials_are_those_of_differences(phi, values, pose, velocity):
    one = cart(phi, UnknownSlope(*values))
    state, rate = np.concatenate([pose, velocity]), np.array([0.3, -0.2, 0.1])
    found = one.inverse(state, rate)
    assert_partials(found.by_state, lambda states: one.inverse(states, rate).wrench, state)
    assert_partials(
        found.by_parameters, lambda others: one.inverse(state, rate, parameters=others).wrench, one.parameters
    )


@given(phis(), poses(), velocities())
def test_of_a_level_floor_it_is_nothing(phi, pose, velocity):
    assert not cart(phi, UnknownSlope()).effect_wrench(np.concatenate([pose, velocity])).any()
