"""Mobility coordinates: a chart of phi, in which the reduced acceleration is linear."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import WheelMisalignment
from cartgrasp.inertia import Inertia, phi_from_physical, physical_from_phi
from cartgrasp.model import CartModel
from estimation.online.augmented.mobility import BodyLimits, build_chart

CONSTRAINTS = {
    "casters": RollingConstraints(axle_x=None),
    "axle": RollingConstraints(0.0),
    "axle off the origin": RollingConstraints(0.4),
    "wheels at an angle": RollingConstraints(0.4, angle=-0.3),
    "rail": RollingConstraints(0.0, no_rotation=True),
}
finite = {"allow_nan": False, "allow_infinity": False}
inertias = st.tuples(
    st.floats(5, 100, **finite),
    st.floats(-0.6, 0.6, **finite),
    st.floats(-0.4, 0.4, **finite),
    st.floats(0.3, 20, **finite),
)


@pytest.mark.parametrize("kind", CONSTRAINTS)
@given(values=inertias)
def test_there_and_back(kind, values):
    chart, phi = build_chart(CONSTRAINTS[kind]), phi_from_physical(*values)
    np.testing.assert_allclose(chart.phi(chart.coordinates(phi)), phi, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("kind", CONSTRAINTS)
@given(values=inertias)
def test_jacobian_against_differences(kind, values):
    chart = build_chart(CONSTRAINTS[kind])
    at = chart.coordinates(phi_from_physical(*values))
    steps = 1e-6 * np.maximum(np.abs(at), 1e-3)
    columns = [(chart.phi(at + h) - chart.phi(at - h)) / (2 * h.max()) for h in np.diag(steps)]
    expected = np.stack(columns, axis=-1)
    scale = np.abs(expected).max(axis=0) + 1e-12
    np.testing.assert_allclose(chart.jacobian(at) / scale, expected / scale, atol=2e-5)


LIMITS = BodyLimits(mass=(2.0, 120.0), com_x=(-0.5, 0.9), com_y=(-0.6, 0.6), inertia=(0.2, 25.0))


@pytest.mark.parametrize("kind", ["casters", "axle", "axle off the origin"])
@given(believed=st.tuples(*[st.floats(-3, 3, **finite)] * 4))
def test_bounded_one_after_the_other_coordinates_are_those_of_a_body(kind, believed):
    chart = build_chart(CONSTRAINTS[kind])
    at = np.array(believed)
    for i in chart.clamped:
        at[i] = np.clip(at[i], *chart.bounds(i, at, LIMITS))
    mass, x, y, inertia = physical_from_phi(chart.phi(at))
    near = 1 + 1e-6
    assert LIMITS.mass[0] / near <= mass <= LIMITS.mass[1] * near
    assert LIMITS.com_x[0] - 1e-6 <= x <= LIMITS.com_x[1] + 1e-6
    assert inertia >= LIMITS.inertia[0] / near - 1e-6
    assert abs(y) <= 0.6 * near or kind != "casters"


@pytest.mark.parametrize("kind", CONSTRAINTS)
def test_bounds_hold_the_first_guess(kind):
    chart, phi = build_chart(CONSTRAINTS[kind]), phi_from_physical(20.0, 0.3, 0.05, 2.0)
    at = chart.coordinates(phi)
    for i in chart.clamped:
        low, high = chart.bounds(i, at, LIMITS)
        assert low <= at[i] <= high


@given(
    values=inertias,
    push=st.tuples(st.floats(-40, 40, **finite), st.floats(-20, 20, **finite)),
    angle=st.sampled_from([0.0, 0.3, -0.2]),
)
def test_acceleration_is_linear_in_the_coordinates(values, push, angle):
    """From rest, u' = a tau_u + b tau_r and r' = b tau_u + c tau_r; with a yaw rate, r' also has -g u r. The push is
    along the wheels."""
    mass, x, y, about = values
    cart = CartModel(Inertia(mass, (x, y), about), effects=(WheelMisalignment(angle),))
    x, y = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)
    a, b, c, g = build_chart(cart.rolling).coordinates(cart.inertia.phi)
    wrench = np.array([push[0] * np.cos(angle), push[0] * np.sin(angle), push[1]])
    rate = cart.state_rate(cart.state(), wrench)[3:5]
    np.testing.assert_allclose(rate, [a * push[0] + b * push[1], b * push[0] + c * push[1]], rtol=1e-9, atol=1e-9)
    turning = cart.state_rate(cart.state(velocity=[0.7, 0.01]), np.zeros(3))[4]
    small = cart.state_rate(cart.state(velocity=[0.7, 0.0]), np.zeros(3))[4]
    assert turning - small == pytest.approx(-g * 0.7 * 0.01 + b * x * mass * 0.01**2, rel=1e-9, abs=1e-12)
