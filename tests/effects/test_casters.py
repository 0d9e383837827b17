"""Casters that swing round, against the trail model in closed form (physics.md).

With the wheel's heading psi against the velocity v: `tan(psi/2) = tan(psi0/2) exp(-v t / b)`, so the way it
takes is `b ln(tan(psi0/2) / tan(psi1/2))`, and the swivel torque T takes the energy `T |psi0 - psi1|`.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import CasterRealignment
from cartgrasp.effects.caster_realignment import DEFAULT_SMOOTHING_RATE
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.wheels import Wheel
from tests.core.drawn import HOSPITAL_BED, SHOPPING_CART, numbers, vectors, velocities

TRAIL = 0.045
TORQUE = 0.3
WRENCH = np.array([10.0, 2.0, 1.0])
INERTIA = Inertia(24.0, (0.3, 0.0), 2.0)


def one_caster(x=0.72, y=0.0, trail=TRAIL, constraints=RollingConstraints(None)):
    wheels = (Wheel("fixed", 0.0, 0.0), Wheel("caster", x, y, trail))
    return CartModel(INERTIA, constraints, (CasterRealignment(TORQUE),), wheels)


def at_heading(cart, heading, velocity):
    state = cart.state(velocity=velocity)
    state[cart.memory_slice] = heading
    return state


@given(psi=numbers(0.05, 3.0), sign=st.sampled_from([1, -1]), speed=numbers(0.3, 2.0))
def test_drag_of_a_caster_across_the_motion(psi, sign, speed):
    """(T/b) |sin psi| against the motion; the smooth sign is low by (DEFAULT_SMOOTHING_RATE / psi')² / 2."""
    cart = one_caster()
    force = cart.effect_wrench(at_heading(cart, sign * psi, [speed, 0.0, 0.0]))
    low = (DEFAULT_SMOOTHING_RATE * TRAIL / (speed * np.sin(psi))) ** 2 / 2
    np.testing.assert_allclose(force[0], -TORQUE / TRAIL * np.sin(psi), rtol=low + 1e-9)


@given(place=vectors(2, -0.8, 0.8), delta=numbers(-3.0, 3.0), trail=numbers(0.02, 0.2))
def test_the_force_is_across_the_wheel_at_its_patch(place, delta, trail):
    cart = one_caster(*place, trail)
    force = cart.effect_wrench(at_heading(cart, delta, [0.7, -0.2, 0.4]))
    across = np.array([-np.sin(delta), np.cos(delta)])
    patch = place - trail * np.array([np.cos(delta), np.sin(delta)])
    strength = force[:2] @ across
    np.testing.assert_allclose(force[:2], strength * across, atol=1e-12)
    np.testing.assert_allclose(force[2], patch[0] * force[1] - patch[1] * force[0], atol=1e-12)
    assert abs(strength) <= TORQUE / trail


@given(place=vectors(2, -0.8, 0.8), delta=numbers(-3.0, 3.0), trail=numbers(0.02, 0.2), velocity=velocities())
def test_a_tyre_takes_its_torque_times_how_fast_the_caster_turns_on_the_floor(place, delta, trail, velocity):
    """Force and torque of the floor on the wheel, whose patch only rolls; its fork turns at r + delta'."""
    scrub, cart = 0.07, one_caster(*place, trail, constraints=RollingConstraints(None))
    cart = replace(cart, effects=(CasterRealignment(scrub_torque=scrub),))
    state = at_heading(cart, delta, velocity)
    turning = velocity[2] + cart.rate(state, np.zeros(3)).value[-1]
    slip = turning / np.hypot(turning, DEFAULT_SMOOTHING_RATE)
    assert cart.effect_wrench(state) @ velocity == pytest.approx(-scrub * slip * turning, abs=1e-9)
    across = np.array([-np.sin(delta), np.cos(delta)])
    force = -scrub / trail * slip * across
    patch = place - trail * np.array([np.cos(delta), np.sin(delta)])
    moment = patch[0] * force[1] - patch[1] * force[0] - scrub * slip
    np.testing.assert_allclose(cart.effect_wrench(state), [*force, moment], atol=1e-9)


@given(x=numbers(-0.8, 0.8), ahead=numbers(-0.8, 0.8), delta=numbers(-3, 3), velocity=velocities())
def test_casters_ahead_of_where_they_are_listed_are_as_those_that_are_listed_there(x, ahead, delta, velocity):
    there = one_caster(x + ahead)
    moved = replace(one_caster(x), effects=(CasterRealignment(TORQUE, x=ahead),))
    (wanted, rest), (found, also_rest) = (
        (cart.rate(state, WRENCH).value, cart.settled_memory(state, cart.parameters))
        for cart in (there, moved)
        for state in [at_heading(cart, delta, velocity)]
    )
    np.testing.assert_allclose(found, wanted, atol=1e-12)
    np.testing.assert_allclose(also_rest, rest, atol=1e-12)


@given(place=vectors(2, -0.8, 0.8), delta=numbers(-4, 4), velocity=velocities())
def test_the_wheel_does_not_slip_sideways_at_its_patch(place, delta, velocity):
    """The patch moves with the fork, which turns at r + delta' about the pivot: it only rolls."""
    cart = one_caster(*place)
    rate = cart.rate(at_heading(cart, delta, velocity), np.zeros(3)).value[-1]
    u, w, r = velocity
    across = np.array([-np.sin(delta), np.cos(delta)])
    pivot = np.array([u - place[1] * r, w + place[0] * r])
    patch = pivot - TRAIL * (r + rate) * across  # d/dt of -b * along
    assert abs(patch @ across) < 1e-12


@pytest.mark.parametrize(("first", "last"), [(175.0, 5.0), (170.0, 2.0), (-175.0, -1.0)])
def test_a_full_swing_takes_its_energy_and_seven_trails(first, last):
    """At constant speed the energy is `T ∫ sin psi / sqrt(sin² psi + e²) dpsi`, e = DEFAULT_SMOOTHING_RATE b / v."""
    cart, speed = one_caster(), 0.8

    def rate(_, heading):
        state = at_heading(cart, heading[:1], [speed, 0.0, 0.0])
        return [cart.rate(state, np.zeros(3)).value[-1], -cart.effect_wrench(state)[0] * speed]

    def aligned(_, heading):
        return np.degrees(heading[0]) - last

    aligned.terminal = True
    run = solve_ivp(rate, (0, 5), [np.radians(first), 0.0], events=aligned, method="DOP853", rtol=1e-9, atol=1e-12)
    way, energy = run.t_events[0][0] * speed, run.y_events[0][0][1]
    psi = np.abs(np.radians([first, last]))
    np.testing.assert_allclose(way, TRAIL * np.log(np.tan(psi[0] / 2) / np.tan(psi[1] / 2)), rtol=1e-7)
    assert 6 < way / TRAIL < 9

    smoothing = np.sqrt(1 + (DEFAULT_SMOOTHING_RATE * TRAIL / speed) ** 2)
    exact = TORQUE * np.diff(np.arcsin(np.cos(psi) / smoothing))[0]
    np.testing.assert_allclose(energy, exact, rtol=1e-6)
    np.testing.assert_allclose(energy, TORQUE * np.ptp(psi), rtol=0.02)  # what smoothing leaves out: 2 e of pi


def test_a_reversal_of_a_cart_costs_the_swing_of_its_casters():
    """What the cart lost of its kinetic energy is T times what its casters swung."""
    cart = CartModel(INERTIA, effects=(CasterRealignment(TORQUE),), wheels=SHOPPING_CART)
    start = cart.state(velocity=[-1.0, 0.0])
    start[cart.memory_slice] = (
        0.05,
        -0.05,
    )  # nearly straight on for rolling forward, so they must turn right round
    run = solve_ivp(lambda _, s: cart.rate(s, np.zeros(3)).value, (0, 0.6), start, rtol=1e-9, atol=1e-11)
    headings = run.y[cart.memory_slice]
    swing = np.abs(headings[:, -1] - headings[:, 0])
    assert np.all(swing > np.radians(170))

    def energy(state):
        u, r = state[cart.velocity_slice]
        return 24.0 / 2 * u**2 + (2.0 + 24.0 * 0.3**2) / 2 * r**2

    # they swing one way only, so the swing is the way; smoothing leaves out up to 4 %
    assert energy(run.y[:, 0]) - energy(run.y[:, -1]) == pytest.approx(TORQUE * swing.sum(), rel=0.04)


def test_it_feels_like_mass_at_a_reversal():
    """The paper's E5: until the casters are round, the cart needs more force; then it does not."""
    cart = CartModel(INERTIA, effects=(CasterRealignment(TORQUE),), wheels=SHOPPING_CART)
    across = cart.effect_wrench(at_heading(cart, [1.5, -1.5], [0.3, 0.0]))
    round_again = cart.effect_wrench(at_heading(cart, [1e-4, -1e-4], [0.3, 0.0]))
    np.testing.assert_allclose(across[0], -2 * TORQUE / TRAIL, rtol=0.01)
    assert abs(round_again[0]) < 0.01


def test_its_own_trail_stands_for_the_listed_ones():
    listed = CartModel(INERTIA, effects=(CasterRealignment(TORQUE),), wheels=HOSPITAL_BED)
    own = CartModel(INERTIA, effects=(CasterRealignment(TORQUE, trail=0.06),), wheels=HOSPITAL_BED)
    state = at_heading(listed, [0.3, -0.2, 1.0, 2.0], [0.5, 0.1])
    np.testing.assert_allclose(own.rate(state, np.zeros(3)).value, listed.rate(state, np.zeros(3)).value)
    assert listed.memory_names == tuple(f"caster{k}.heading" for k in (1, 2, 3, 4))


@given(heading=numbers(-3.0, 3.0), u=numbers(0.3, 1.0), r=numbers(-0.5, 0.5))
def test_settles_where_the_trail_model_takes_it(heading, u, r):
    """Against the heading integrated over 40 trails of travel."""
    cart = one_caster()
    state = at_heading(cart, heading, [u, 0.0, r])

    def rate(_, memory):
        return cart.state_rate(at_heading(cart, memory, [u, 0.0, r]), np.zeros(3))[cart.memory_slice]

    ended = solve_ivp(rate, (0.0, 40 * TRAIL / u), [heading], rtol=1e-8).y[0, -1]
    settled = cart.settled_memory(state, cart.parameters)[0]
    assert settled == pytest.approx(ended, abs=1e-3)
