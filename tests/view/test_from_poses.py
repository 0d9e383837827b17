"""Velocity and casters told by poses, against closed forms and the casters' own differential equation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cartgrasp.view.from_poses import trailing_headings, velocity_of_poses
from cartgrasp.wheels import Wheel

from .conftest import shopping_cart

TRAIL = 0.045


def arc(time: np.ndarray, speed: float, rate: float) -> np.ndarray:
    """Poses on a circle from the origin along x."""
    theta = rate * time
    return np.stack(
        [speed * np.sinc(theta / np.pi) * time, speed * time * np.sin(theta / 2) ** 2 / (theta / 2), theta], 1
    )


@given(st.floats(-1, 1), st.floats(0.05, 0.8), st.floats(0.005, 0.06))
def test_velocity_on_a_circle(speed: float, rate: float, step: float):
    time = np.arange(0.1, 5, step)
    inside = slice(len(time) // 4, -len(time) // 4)
    expected = np.stack([speed * np.cos(rate * time), speed * np.sin(rate * time), np.full(len(time), rate)], 1)
    found = velocity_of_poses(time, arc(time, speed, rate))
    # Of a sine, means over windows lose (rate window)² / 6 or less.
    np.testing.assert_allclose(found[inside], expected[inside], atol=0.2 * 0.8**2 * 0.12**2 + 1e-9)


def test_velocity_forgives_wraps_of_the_heading_and_stays_missing_in_gaps():
    time = np.arange(0, 10, 0.01)
    pose = np.stack([time, 0 * time, (2.0 * time + np.pi) % (2 * np.pi) - np.pi], 1)
    pose[300:400] = np.nan
    found = velocity_of_poses(time, pose)
    np.testing.assert_array_equal(np.isnan(found).all(axis=1), np.isnan(pose[:, 0]))
    np.testing.assert_allclose(found[np.isfinite(found[:, 0])], np.tile([1.0, 0.0, 2.0], (900, 1)), atol=1e-9)


def test_velocity_says_less_noise_than_poses_have():
    """Of white noise the differences of means over w rows have the deviation σ √(2/w) / (their times' distance)."""
    time = np.arange(0, 60, 0.01)
    noise = np.random.default_rng(0).normal(scale=0.001, size=(len(time), 3))
    inside = velocity_of_poses(time, noise)[50:-50]
    assert inside.std() == pytest.approx(0.001 * np.sqrt(2 / 11) / 0.1, rel=0.15)


def test_one_pose_has_no_velocity():
    assert np.isnan(velocity_of_poses(np.array([3.0]), np.zeros((1, 3)))).all()


def test_casters_obey_their_differential_equation():
    """delta' = (cos(delta) v_pivot - sin(delta) u_pivot) / trail - r in {b}, which shares nothing with tractrices."""
    time = np.arange(0, 20, 0.005)
    speed, rate = 0.4 * np.ones(len(time)), 0.8 * np.sin(time)
    theta = -0.8 * np.cos(time) + 0.8
    velocity = np.stack([speed * np.cos(theta), speed * np.sin(theta)], 1)
    pose = np.column_stack([np.cumsum(velocity, axis=0) * 0.005, theta])
    cart = shopping_cart()
    found = trailing_headings(pose, cart)
    assert found is not None
    casters = [wheel for wheel in cart.wheels if wheel.kind == "caster"]
    for heading, wheel in zip(found.T, casters, strict=True):

        def slope(t: float, delta: np.ndarray, wheel: Wheel = wheel) -> np.ndarray:
            r = np.interp(t, time, rate)
            along, across = 0.4 - wheel.y * r, wheel.x * r
            return (np.cos(delta) * across - np.sin(delta) * along) / TRAIL - r

        settled = solve_ivp(slope, (0, 20), [heading[0]], t_eval=time, rtol=1e-8, atol=1e-8).y[0]
        # A pivot waits for a fifth of its trail, which is 0.02 s, and headings turn by up to 2 rad/s here.
        np.testing.assert_allclose(heading[200:], settled[200:], atol=0.04)


def test_casters_at_rest_do_not_turn_with_the_noise_of_poses():
    rng = np.random.default_rng(0)
    forward = np.column_stack([np.linspace(0, 1, 400), np.zeros(400), np.zeros(400)])
    rest = np.tile(forward[-1], (4000, 1)) + rng.normal(scale=0.0004, size=(4000, 3))
    found = trailing_headings(np.vstack([forward, rest]), shopping_cart())
    assert found is not None
    assert np.abs(found).max() < 0.02


def test_casters_of_a_cart_that_never_moves_are_unknown():
    found = trailing_headings(np.zeros((10, 3)), shopping_cart())
    assert found is not None
    assert np.isnan(found).all()
    assert found.shape == (10, 2)
