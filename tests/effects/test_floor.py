"""Slopes and patches against the energy that it takes to climb and to cross them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from scipy.integrate import solve_ivp

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import FloorPatch, FloorSlope, RollingResistance
from cartgrasp.effects.floor_patch import SMOOTHING_LENGTH
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.wheels import GRAVITY
from tests.core.drawn import CONSTRAINTS, SHOPPING_CART, inertias, numbers, poses, vectors

GRADE = (0.03, -0.02)
CART = CartModel(Inertia(24.0, (0.36, 0.05), 2.0), wheels=SHOPPING_CART)


def height_of_com(pose, com, grade):
    x, y, theta = pose
    com_x = x + com[0] * np.cos(theta) - com[1] * np.sin(theta)
    com_y = y + com[0] * np.sin(theta) + com[1] * np.cos(theta)
    return grade[0] * com_x + grade[1] * com_y


def kinetic_energy(cart, state):
    """From the velocity of the CoM and the inertia about it."""
    u, w, r = cart.basis_b @ state[cart.velocity_slice]
    com_x, com_y = cart.inertia.com
    at_com = np.array([u - com_y * r, w + com_x * r])
    return cart.inertia.mass / 2 * at_com @ at_com + cart.inertia.about_com / 2 * r**2


@pytest.mark.parametrize("constraints", CONSTRAINTS.values(), ids=CONSTRAINTS.keys())
def test_a_cart_left_on_a_slope_keeps_its_energy(constraints):
    cart = CartModel(Inertia(24.0, (0.3, 0.1), 2.0), constraints, (FloorSlope(*GRADE),))
    start = cart.state((0.2, -0.1, 0.4), [0.8, -0.3, 0.5][: constraints.n_free])
    run = solve_ivp(
        lambda _, s: cart.rate(s, np.zeros(3)).value, (0, 5), start, method="DOP853", rtol=1e-10, atol=1e-12
    )

    def energy(state):
        potential = 24.0 * GRAVITY * height_of_com(state[:3], cart.inertia.com, GRADE)
        return kinetic_energy(cart, state) + potential

    energies = [energy(state) for state in run.y.T]
    np.testing.assert_allclose(energies, energies[0], rtol=1e-8)
    assert np.ptp([kinetic_energy(cart, state) for state in run.y.T]) > 0.1  # J: it did climb or fall


@given(inertia=inertias(), pose=poses(), grade=vectors(2, -0.1, 0.1))
def test_the_slope_pulls_down_the_gradient_of_the_height(inertia, pose, grade):
    """Virtual work: wrench · displacement = -m g dh, by central differences of the height of the CoM."""
    cart = CartModel(inertia, RollingConstraints(None), (FloorSlope(*grade),))
    wrench_b = cart.effect_wrench(cart.state(pose))
    step = 1e-4
    for k, displacement_b in enumerate(np.eye(3)):
        cosine, sine = np.cos(pose[2]), np.sin(pose[2])
        moved = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]]) @ displacement_b * step
        rise = height_of_com(pose + moved, inertia.com, grade) - height_of_com(pose - moved, inertia.com, grade)
        # rounding: 1e-15 of height over the step; truncation: step² of a sine
        work = -inertia.mass * GRAVITY * rise / (2 * step)
        np.testing.assert_allclose(wrench_b[k], work, rtol=1e-7, atol=1e-8)


@given(heading=numbers(-np.pi, np.pi))
def test_a_straight_cart_rolls_downhill_at_g_times_the_grade(heading):
    cart = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), CONSTRAINTS["rail"], (FloorSlope(*GRADE),))
    acceleration = cart.rate(cart.state((0.0, 0.0, heading)), np.zeros(3)).value[3]
    grade = GRADE[0] * np.cos(heading) + GRADE[1] * np.sin(heading)
    np.testing.assert_allclose(acceleration, -GRAVITY * grade, atol=1e-12)


def drag_at(cart, x, y=0.0, heading=0.0, speed=1.0):
    return cart.effect_wrench(cart.state((x, y, heading), [speed, 0.0]))


@given(length=numbers(0.05, 2.0), speed=numbers(0.5, 2.0), coefficient=numbers(0.01, 0.2))
def test_crossing_a_strip_costs_its_length_times_the_drag(length, speed, coefficient):
    """`∫ fx dx = -c m g L`: the product of two edges, smoothed over h, has the area L / (1 - exp(-2 L / h)).

    The smooth sign is low by (s/u)²/2, 8e-6 at most. Of a smooth function that vanishes at both ends the
    trapezoid rule has an error of exp(-pi² h / step), 4e-22.
    """
    patch = FloorPatch(x_min=1.0, x_max=1.0 + length, y_min=-5.0, y_max=5.0, coefficient=coefficient)
    cart = CART.with_effect(patch)
    x = np.arange(0.0, 1.3 + length, 0.001)
    states = np.tile(cart.state(velocity=[speed, 0.0]), (len(x), 1))
    states[:, 0] = x
    work = 0.001 * cart.effect_wrench(states)[:, 0].sum()
    np.testing.assert_allclose(work, -coefficient * 24.0 * GRAVITY * length, rtol=2e-5)


def test_a_patch_is_rolling_resistance_inside_and_nothing_outside():
    patch = CART.with_effect(FloorPatch(1.0, 3.0, -1.0, 1.0, coefficient=0.05))
    rolling = CART.with_effect(RollingResistance(0.05))
    np.testing.assert_allclose(drag_at(patch, 1.5), drag_at(rolling, 1.5), rtol=1e-12)
    np.testing.assert_allclose(drag_at(patch, 1.5, heading=0.7), drag_at(rolling, 1.5), rtol=1e-12)
    for x, y in ((0.0, 0.0), (3.5, 0.0), (1.5, 2.0), (1.5, -2.0)):
        assert np.abs(drag_at(patch, x, y)).max() < 1e-12


def test_each_wheel_feels_the_patch_by_itself():
    """Left wheels on a carpet turn the cart to the left; front wheels alone drag by their own load."""
    left = drag_at(CART.with_effect(FloorPatch(0.0, 3.0, 0.0, 1.0, coefficient=0.05)), 1.0)
    assert left[0] < 0 < left[2]
    front = drag_at(CART.with_effect(FloorPatch(1.4, 3.0, -1.0, 1.0, coefficient=0.05)), 1.0)
    front_load = 24.0 * GRAVITY * 0.36 / 0.72
    np.testing.assert_allclose(front[0], -0.05 * front_load, rtol=1e-5)


def test_the_edge_of_a_patch_is_a_centimetre_wide():
    cart = CART.with_effect(FloorPatch(1.72, 3.0, -1.0, 1.0, coefficient=0.05))
    steady = drag_at(cart, 1.3)[0]
    at_edge, before, after = (
        drag_at(cart, 1.0 + way)[0] / steady for way in (0.0, -2 * SMOOTHING_LENGTH, 2 * SMOOTHING_LENGTH)
    )
    assert at_edge == pytest.approx(0.5, abs=1e-3)
    assert before < 0.02
    assert after > 0.98
