"""What happens at a time, and what a sensor makes of a wrench, against impulse, mass moments and geometry."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from scipy.integrate import solve_ivp

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ExternalPush, ForceBias, ForceMisalignment, ForceScale, PayloadChange
from cartgrasp.effects.external_push import RISE_TIME
from cartgrasp.inertia import Inertia, phi_from_physical
from cartgrasp.model import CartModel
from tests.core.drawn import numbers, vectors

INERTIA = Inertia(24.0, (0.0, 0.0), 2.0)


@given(start=numbers(0.5, 5), duration=numbers(0, 3), force=numbers(-60, 60), moment=numbers(-10, 10))
def test_the_impulse_of_a_push_is_force_times_duration(start, duration, force, moment):
    """However short: the window's integral is its duration.

    The trapezoid rule is off by exp(-pi² RISE_TIME / step), 4e-22; beyond 20 rises the window is below exp(-40).
    """
    cart = CartModel(INERTIA, effects=(ExternalPush(start, duration, force, moment),))
    times = np.arange(start - 20 * RISE_TIME, start + duration + 20 * RISE_TIME, 0.001)
    impulse = 0.001 * cart.effect_wrench(np.tile(cart.state(), (len(times), 1)), time=times).sum(axis=0)
    np.testing.assert_allclose(impulse, [force * duration, 0, moment * duration], atol=1e-9)


def test_a_push_moves_a_cart_at_rest_by_its_impulse():
    cart = CartModel(INERTIA, RollingConstraints(0.0), (ExternalPush(0.5, 0.3, 30.0, 4.0),))
    run = solve_ivp(
        lambda t, s: cart.rate(s, np.zeros(3), time=t).value, (0, 1), cart.state(), max_step=0.005, rtol=1e-8
    )
    u, r = run.y[cart.velocity_slice, -1]
    assert u == pytest.approx(30.0 * 0.3 / 24.0, rel=1e-6)
    assert r == pytest.approx(4.0 * 0.3 / 2.0, rel=1e-6)


def test_a_push_is_there_within_its_window_only():
    cart = CartModel(INERTIA, effects=(ExternalPush(1.0, 0.5, 30.0, 4.0),))
    times = np.array([0.9, 1.0, 1.05, 1.25, 1.45, 1.5, 1.6])
    wrench = cart.effect_wrench(np.tile(cart.state(), (7, 1)), time=times)
    np.testing.assert_allclose(wrench[:, 0], 30.0 * np.array([0, 0.5, 1, 1, 1, 0.5, 0]), atol=1e-6)
    np.testing.assert_allclose(wrench[:, 2], wrench[:, 0] * 4.0 / 30.0)


@given(mass=numbers(-10, 20), place=vectors(2, -0.5, 0.5), com=vectors(2, -0.3, 0.3))
def test_a_payload_adds_its_mass_moments_from_its_time_on(mass, place, com):
    """phi is a sum over mass: 1, x, y, x² + y² of each part about {b}'s origin."""
    cart = CartModel(Inertia(24.0, tuple(com), 4.0), effects=(PayloadChange(2.0, mass, *place),))
    before = phi_from_physical(24.0, *com, 4.0)
    np.testing.assert_array_equal(cart.phi_at(1.999), before)
    after = before + mass * np.array([1, place[0], place[1], place @ place])
    np.testing.assert_allclose(cart.phi_at(2.0), after)
    np.testing.assert_allclose(cart.phi_at(np.array([1.0, 3.0])), [before, after])


@given(bias=vectors(3, -5, 5), wrench=vectors(6, -50, 50))
def test_a_sensor_without_tare_reads_its_bias_at_rest(bias, wrench):
    effect = ForceBias(*bias)
    np.testing.assert_array_equal(effect.recorded(np.zeros(6), effect.values), [*bias[:2], 0, 0, 0, bias[2]])
    np.testing.assert_allclose(
        effect.recorded(wrench, effect.values) - wrench, [*bias[:2], 0, 0, 0, bias[2]], atol=1e-13
    )


@given(gain=numbers(0.2, 5), wrench=vectors(6, -50, 50))
def test_a_wrong_gain_scales_every_axis(gain, wrench):
    effect = ForceScale(gain)
    np.testing.assert_allclose(effect.recorded(wrench, effect.values), gain * wrench)
    np.testing.assert_allclose(effect.corrected(wrench, effect.values).value, wrench / gain)


@given(angle=numbers(-3, 3), force=numbers(-50, 50), wrench=vectors(6, -50, 50))
def test_a_turned_sensor_sees_a_forward_force_to_its_right(angle, force, wrench):
    """Axes turned by +angle see the x force as (cos, -sin); norms and z stay."""
    effect = ForceMisalignment(angle)
    recorded = effect.recorded(force * np.eye(6)[0], effect.values)
    np.testing.assert_allclose(recorded, force * np.array([np.cos(angle), -np.sin(angle), 0, 0, 0, 0]), atol=1e-12)
    turned = effect.recorded(wrench, effect.values)
    np.testing.assert_allclose(turned[[2, 5]], wrench[[2, 5]])
    for pair in ([0, 1], [3, 4]):
        np.testing.assert_allclose(np.hypot(*turned[pair]), np.hypot(*wrench[pair]))
        complex_wrench = complex(*wrench[pair]) * np.exp(-1j * angle)
        np.testing.assert_allclose(turned[pair], [complex_wrench.real, complex_wrench.imag], atol=1e-12)
