"""Drags against their closed forms: coasting to rest, and what the force is where one can say it by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from scipy.integrate import solve_ivp
from scipy.special import erfi

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import (
    DirectionalDrag,
    QuadraticDrag,
    RollingResistance,
    StribeckFriction,
    ViscousDrag,
    WheelDragImbalance,
)
from cartgrasp.effects.effect import SMOOTHING_SPEED
from cartgrasp.inertia import Inertia, phi_from_physical
from cartgrasp.model import CartModel
from cartgrasp.wheels import GRAVITY, Wheel
from tests.core.drawn import CONSTRAINTS, SHOPPING_CART, numbers, vectors

MASS = 24.0
TRAIL = SHOPPING_CART[2].trail
RAIL = CONSTRAINTS["rail"]


def rail_cart(*effects, mass=MASS):
    """Moves along x only, so that it coasts as one equation."""
    return CartModel(Inertia(mass, (0.0, 0.0), 2.0), RAIL, effects)


def coast(cart, speed, times, stop=None):
    """Speeds (n,) at the times of a cart that starts at `speed`; `stop` ends the run at a speed."""

    def rate(_, state):
        return cart.rate(state, np.zeros(3)).value

    def reached(_, state):
        return state[3] - stop

    reached.terminal = True
    state = cart.state(velocity=[speed])
    events = None if stop is None else reached
    return solve_ivp(rate, (0, times[-1]), state, t_eval=times, events=events, method="DOP853", rtol=1e-9, atol=1e-12)


def force_at(effect, u, w=0.0, r=0.0, *, wheels=(), phi=None, constraints=None, headings=()):
    cart = CartModel(Inertia(MASS, (0.0, 0.0), 2.0), constraints or RollingConstraints(None), (effect,), wheels)
    parameters = cart.parameters.copy()
    if phi is not None:
        parameters[:4] = phi
    velocity = {3: [u, w, r], 2: [u, r], 1: [u]}[cart.constraints.n_free]
    state = cart.state(velocity=velocity)
    if len(headings):
        state[cart.memory_slice] = headings
    return cart.effect_wrench(state, parameters)


@given(drag=numbers(0.5, 50), speed=numbers(-2, 2), yaw_rate=numbers(-2, 2))
def test_viscous_drag_is_exponential_decay(drag, speed, yaw_rate):
    np.testing.assert_allclose(
        force_at(ViscousDrag(drag, drag / 3), speed, 0.1, yaw_rate),
        [-drag * speed, -drag * 0.1, -drag / 3 * yaw_rate],
    )


def test_viscous_cart_coasts_exponentially():
    times = np.linspace(0, 8, 9)
    run = coast(rail_cart(ViscousDrag(5.0)), 1.5, times)
    np.testing.assert_allclose(run.y[3], 1.5 * np.exp(-5.0 / MASS * times), rtol=1e-7)
    way = run.y[0, -1]
    np.testing.assert_allclose(way, MASS / 5.0 * (1.5 - run.y[3, -1]), rtol=1e-7)  # impulse = 5 N·s/m × way


def test_quadratic_drag_coasts_hyperbolically():
    times = np.linspace(0, 10, 11)
    for start in (1.2, -1.2):
        run = coast(rail_cart(QuadraticDrag(4.0)), start, times)
        np.testing.assert_allclose(run.y[3], start / (1 + 4.0 * abs(start) / MASS * times), rtol=1e-7)


@given(coefficient=numbers(0.1, 10), velocity=vectors(2, -2, 2))
def test_quadratic_drag_opposes_the_velocity(coefficient, velocity):
    force = force_at(QuadraticDrag(coefficient), *velocity)
    np.testing.assert_allclose(force[:2], -coefficient * np.hypot(*velocity) * velocity, atol=1e-12)
    straight = force_at(QuadraticDrag(coefficient), velocity[0])
    np.testing.assert_allclose(straight, [-coefficient * velocity[0] * abs(velocity[0]), 0, 0], atol=1e-12)


def test_directional_drag_decays_at_one_rate_forward_and_at_another_backward():
    cart = rail_cart(DirectionalDrag(forward=3.0, backward=8.0), ViscousDrag(1.0))
    times = np.linspace(0, 4, 5)
    # above 0.2 m/s the smooth sign is off by (s / 2u)² = 2.5e-5 at most; the two drags differ by 5 of 9 N·s/m
    forward, backward = coast(cart, 1.0, times).y[3], coast(cart, -1.0, times).y[3]
    np.testing.assert_allclose(forward, np.exp(-4.0 / MASS * times), rtol=1e-4)
    np.testing.assert_allclose(backward, -np.exp(-9.0 / MASS * times), rtol=1e-4)


@given(forward=numbers(0, 10), backward=numbers(0, 10))
def test_directional_drag_is_continuous_and_monotonous(forward, backward):
    speeds = np.linspace(-0.02, 0.02, 401)
    force = np.array([force_at(DirectionalDrag(forward, backward), u)[0] for u in speeds[::40]])
    assert np.all(np.abs(force) <= max(forward, backward) * np.abs(speeds[::40]) + 1e-15)


def test_directional_drag_of_one_value_is_viscous():
    for u in (-1.0, -1e-3, 0.0, 1e-3, 1.0):
        np.testing.assert_allclose(force_at(DirectionalDrag(4.0, 4.0), u), force_at(ViscousDrag(4.0), u), atol=1e-15)


def test_stribeck_friction_stops_in_the_time_of_its_integral():
    """m u' = -F exp(-(u/v)²) takes `m v sqrt(pi)/2 (erfi(u0/v) - erfi(u1/v)) / F` from u0 down to u1.

    At u1 = 20 s the smooth sign is low by 1/(2·20²) = 0.12 %, and less above.
    """
    force, fade, first = 6.0, 0.1, 0.15
    last = 20 * SMOOTHING_SPEED
    run = coast(rail_cart(StribeckFriction(force, fade)), first, np.array([0.0, 10.0]), stop=last)
    time = MASS * fade * np.sqrt(np.pi) / 2 * (erfi(first / fade) - erfi(last / fade)) / force
    np.testing.assert_allclose(run.t_events[0][0], time, rtol=1.3e-3)


@given(direction=numbers(-np.pi, np.pi), ratio=numbers(0.3, 3.0))
def test_stribeck_friction_fades_in_every_direction_alike(direction, ratio):
    speed = 0.1 * ratio
    force = force_at(StribeckFriction(6.0, 0.1), speed * np.cos(direction), speed * np.sin(direction))
    expected = -6.0 * np.exp(-(ratio**2)) * np.array([np.cos(direction), np.sin(direction)])
    np.testing.assert_allclose(force[:2], expected, rtol=0, atol=6.0 * (SMOOTHING_SPEED / speed) ** 2)
    assert force[2] == 0


@given(
    com=vectors(2, -0.12, 0.12),
    velocity=vectors(3, -0.3, 0.3),
    speed=numbers(0.05, 0.2),
    by_wheels=numbers(0, 1),
    headings=vectors(2, -3, 3),
)
def test_stribeck_friction_of_wheels_is_shared_as_their_loads(com, velocity, speed, by_wheels, headings):
    """By one complex number a wheel: forces at their places, whose moments are those of crossed vectors. Each wheel's
    speed is that of its place along its heading."""
    phi = phi_from_physical(MASS, 0.36 + com[0], com[1], 2.0)
    loads = CartModel(Inertia(MASS, (0.0, 0.0), 2.0), wheels=SHOPPING_CART).wheel_set.loads(phi)
    u, w, r = velocity
    expected = np.zeros(3)
    parts = [(by_wheels * load / loads.sum(), wheel) for load, wheel in zip(loads, SHOPPING_CART, strict=True)]
    turned = iter(np.exp(1j * headings))
    for share, wheel in [*parts, (1 - by_wheels, None)]:
        place = complex(wheel.x, wheel.y) if wheel else 0.0j
        rolls = complex(u, w) + 1j * r * place
        if wheel:
            heading = next(turned) if wheel.kind == "caster" else 1.0
            rolls = (rolls * np.conj(heading)).real * heading
        force = -6.0 * share * np.exp(-((abs(rolls) / speed) ** 2)) * rolls / np.hypot(abs(rolls), SMOOTHING_SPEED)
        expected += [force.real, force.imag, (place.conjugate() * force).imag]
    effect = StribeckFriction(6.0, speed, by_wheels)
    force = force_at(effect, u, w, r, wheels=SHOPPING_CART, phi=phi, headings=headings)
    np.testing.assert_allclose(force, expected, rtol=0, atol=1e-12)


@given(
    com=vectors(2, -0.5, 0.5),
    coefficient=numbers(0.001, 0.1),
    speed=numbers(0.2, 2),
    mass=numbers(5, 60),
)
def test_rolling_resistance_of_a_straight_run_is_that_of_the_weight(com, coefficient, speed, mass):
    """c m g wherever the CoM is, also where a wheel lifts; smoothing takes (s/u)²/2, 5e-5."""
    phi = phi_from_physical(mass, 0.36 + com[0], com[1], 2.0)
    for sign in (1, -1):
        for wheels in (SHOPPING_CART, ()):
            force = force_at(RollingResistance(coefficient), sign * speed, wheels=wheels, phi=phi)
            np.testing.assert_allclose(force[0], -sign * coefficient * mass * GRAVITY, rtol=6e-5)
            assert abs(force[1]) < 1e-12


@given(com=vectors(2, -0.15, 0.15))
def test_rolling_resistance_pulls_where_the_load_is(com):
    """In a straight run the loads' resultant is at the CoM, and so is the drag's: its moment is c m g dy."""
    phi = phi_from_physical(MASS, 0.36 + com[0], com[1], 2.0)
    force = force_at(RollingResistance(0.02), 1.0, wheels=SHOPPING_CART, phi=phi)
    np.testing.assert_allclose(force[2], 0.02 * MASS * GRAVITY * com[1], rtol=1e-5, atol=1e-12)


def test_rolling_cart_stops_after_u2_by_2cg():
    """The way to 20 smoothing speeds is (u0² - u1²) / (2 c g); the sign is at most 0.12 % low there."""
    last = 20 * SMOOTHING_SPEED
    cart = rail_cart(RollingResistance(0.02))
    run = coast(cart, 1.0, np.array([0.0, 10.0]), stop=last)
    np.testing.assert_allclose(run.y_events[0][0][0], (1 - last**2) / (2 * 0.02 * GRAVITY), rtol=1.3e-3)


@given(yaw_rate=numbers(0.5, 2))
def test_rolling_resistance_of_a_turn_on_the_spot(yaw_rate):
    """Each wheel rolls along its circle: fixed ones at y = ±h have the lever h; casters that have swung round that of
    their patch, which is closer by the trail."""
    phi = phi_from_physical(MASS, 0.3, 0.0, 2.0)
    front = MASS * GRAVITY * 0.3 / 0.72
    back = MASS * GRAVITY - front
    distance = np.hypot(0.72, 0.2)
    inwards = np.arcsin(TRAIL / distance)  # the wheel's axle points at the middle of the circle
    headings = [np.arctan2(0.72, -y) - inwards for y in (0.2, -0.2)]
    force = force_at(RollingResistance(0.03), r=yaw_rate, u=0.0, wheels=SHOPPING_CART, phi=phi, headings=headings)
    expected = -0.03 * (back * 0.27 + front * np.sqrt(distance**2 - TRAIL**2))
    np.testing.assert_allclose(force[2], expected, rtol=2e-4)  # (s / 0.135)² / 2


@given(speed=numbers(-2, 2), y=numbers(-0.4, 0.4), extra=numbers(0.1, 10))
def test_wheel_drag_imbalance_is_a_wheel_at_y_that_drags_more(speed, y, extra):
    """A single fixed wheel at (0, y) under its own weight drags so, by rolling_resistance's road."""
    assume(abs(y) > 1e-3)
    wheel = (Wheel("fixed", 0.0, y),)
    coefficient = extra / (MASS * GRAVITY)
    phi = phi_from_physical(MASS, 0.0, y, 2.0)
    other = force_at(RollingResistance(coefficient), speed, wheels=wheel, phi=phi)
    own = force_at(WheelDragImbalance(extra, y * extra), speed)
    np.testing.assert_allclose(own, other, rtol=1e-9, atol=1e-12)


@given(velocity=vectors(2, -2, 2), left=numbers(0.05, 0.4), right=numbers(0.05, 0.4), drags=vectors(2, 0, 10))
def test_wheels_that_drag_do_so_against_their_own_rolling(velocity, left, right, drags):
    """Also where the cart turns about one of them: Coulomb's two drags at (0, left) and (0, -right), written out."""
    wheels = Wheel("fixed", 0.0, left), Wheel("caster", 0.7, 0.6, 0.05), Wheel("fixed", 0.0, -right)
    (u, r), (of_left, of_right) = velocity, drags
    speeds = u - left * r, u + right * r
    on_left, on_right = (f * v / np.hypot(v, SMOOTHING_SPEED) for f, v in zip((of_left, of_right), speeds, strict=True))
    effect = WheelDragImbalance(of_left + of_right, left * of_left - right * of_right)
    own = force_at(effect, u, 0.0, r, wheels=wheels)
    np.testing.assert_allclose(own, [-on_left - on_right, 0, left * on_left - right * on_right], atol=1e-9)


@pytest.mark.parametrize("y", [0.27, -0.27])
def test_a_tight_left_wheel_turns_the_cart_to_the_left(y):
    moment = force_at(WheelDragImbalance(3.0, 3.0 * y), 1.0)[2]
    assert np.sign(moment) == np.sign(y)
    assert force_at(WheelDragImbalance(3.0, 3.0 * y), -1.0)[2] == -moment
