"""A load that swings, against two masses on a spring: closed forms, energy, momentum, and fits to an own simulation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from scipy.integrate import solve_ivp

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import CasterRealignment, LoadSlosh, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.simulation.plant import ModelPlant
from estimation import CartFilter, FilterNoise
from estimation.batch import identify
from estimation.replay import replay
from tests.core.drawn import SHOPPING_CART, numbers, vectors
from tests.estimation.runs import CONTACT, STEP, push, record

MASS, SLOSH = 20.0, 6.0


def cart(*effects, constraints=RollingConstraints()):
    return CartModel(Inertia(MASS, (0.3, 0.1), 2.0), constraints, effects)


@given(mass=numbers(0.5, 20), frequency=numbers(0.2, 3), force=numbers(-50, 50), time=numbers(0.1, 3))
def test_two_masses_on_a_spring_under_a_step_of_force(mass, frequency, force, time):
    """Without damping, s = -(F / M) (1 - cos w t) / w² with w² = omega² (1 + m / M), and (M + m) of momentum is F t."""
    model = cart(LoadSlosh(mass, frequency, 0.0), constraints=RollingConstraints(0.0, no_rotation=True))
    run = solve_ivp(
        lambda _, s: model.state_rate(s, np.array([force, 0.0, 0.0])), (0, time), model.state(), rtol=1e-9, atol=1e-11
    )
    u, stretch, speed = run.y[3:, -1]
    w = 2 * np.pi * frequency * np.sqrt(1 + mass / MASS)
    expected = -force / MASS * (1 - np.cos(w * time)) / w**2
    rate = -force / MASS * np.sin(w * time) / w
    assert stretch == pytest.approx(expected, rel=1e-6, abs=1e-7)
    assert u == pytest.approx((force * time - mass * rate) / (MASS + mass), rel=1e-6, abs=1e-7)
    assert speed - u == pytest.approx(rate, rel=1e-6, abs=1e-6)


@given(mass=numbers(0.5, 20), frequency=numbers(0.2, 3), damping=numbers(0, 1), nu=vectors(2, -1, 1))
def test_only_its_damper_takes_energy(mass, frequency, damping, nu):
    """d/dt (cart + m v²/2 + m omega² s²/2) = power of the arms - 2 m zeta omega (v - u)², also while turning."""
    model, omega = cart(LoadSlosh(mass, frequency, damping)), 2 * np.pi * frequency
    state = model.state((0.1, 0.2, 0.3), nu)
    state[model.memory_slice] = 0.04, nu[0] + 0.3
    wrench_b = np.array([10.0, 3.0, -4.0])
    rate = model.state_rate(state, wrench_b)
    bare = cart().state_rate(state[:5], wrench_b)
    # what the effect gives the cart: its kinetic energy's rate beyond that of the arms
    m, (dx, dy), inertia = MASS, (0.3, 0.1), 2.0
    matrix = np.array([[m, -m * dy], [-m * dy, inertia + m * (dx**2 + dy**2)]])
    to_cart = nu @ matrix @ (rate[3:5] - bare[3:5])
    stretch, speed = state[5:]
    to_load = mass * speed * rate[6] + mass * omega**2 * stretch * rate[5]
    lost = 2 * mass * damping * omega * (speed - nu[0]) ** 2
    assert to_cart + to_load == pytest.approx(-lost, rel=1e-9, abs=1e-9)


def test_it_begins_and_ends_at_rest_on_the_cart():
    model = cart(LoadSlosh(SLOSH, 1.2, 0.2))
    moving = model.state(velocity=[0.7, 0.2])
    np.testing.assert_array_equal(moving[model.memory_slice], [0.0, 0.7])
    np.testing.assert_array_equal(model.effect_wrench(moving), np.zeros(3))
    swinging = moving.copy()
    swinging[model.memory_slice] = 0.05, -0.2
    ended = solve_ivp(
        lambda _, memory: model.state_rate(np.append(moving[:5], memory), np.zeros(3))[model.memory_slice],
        (0.0, 10.0),
        swinging[model.memory_slice],
        rtol=1e-8,
    ).y[:, -1]
    np.testing.assert_allclose(model.settled_memory(swinging, model.parameters), ended, atol=1e-5)


def test_headings_of_casters_beside_it_are_told_apart():
    model = CartModel(
        Inertia(MASS, (0.3, 0.0), 2.0), effects=(LoadSlosh(SLOSH), CasterRealignment(0.1)), wheels=SHOPPING_CART
    )
    plant = ModelPlant(model, velocity=[0.5, 0.0], caster_headings=[1.0, -2.0])
    np.testing.assert_array_equal(plant.caster_headings, [1.0, -2.0])
    np.testing.assert_array_equal(plant.state[model.memory_slice], [0.0, 0.5, 1.0, -2.0])


def swung(seed, force_noise, duration=20.0):
    """Two masses integrated here, pushed straight on, with drag of the cart."""
    omega, damping, drag = 2 * np.pi * 0.8, 0.08, 3.0

    def rate(_, state, force):
        _, u, stretch, speed = state
        pull = SLOSH * (omega**2 * stretch + 2 * damping * omega * (speed - u))
        return [u, (force - drag * u + pull) / MASS, speed - u, -pull / SLOSH]

    state, states, forces = np.zeros(4), [], []
    for k in range(round(duration / STEP)):
        force = push(k * STEP)[0]
        states.append([state[0], 0.0, 0.0, state[1], 0.0])
        forces.append(force)
        state = solve_ivp(rate, (0, STEP), state, args=(force,), rtol=1e-6, atol=1e-9).y[:, -1]
    wrench = np.zeros((len(states), 6))
    wrench[:, 0] = forces
    wrench[:, 5] = CONTACT[1] * wrench[:, 0]
    return record(np.array(states), {"hand": (CONTACT, wrench)}, (0.0004, 0.005, force_noise), seed)


def test_a_fit_and_the_filter_tell_what_swings_from_what_does_not():
    log = swung(seed=3, force_noise=1.0)
    guess = CartModel(Inertia(24.0, (0.0, 0.0), 2.0), effects=(ViscousDrag(2.0, 1.0), LoadSlosh(2.0, 0.8, 0.08)))
    noise = FilterNoise(0.0004, 0.0004, 0.005, 0.005, 1.0, 0.05)
    batch = identify([log], guess, noise=noise).parameters
    online = replay(log, CartFilter(guess, ["hand"], noise=noise)).last.parameters
    for found in (batch, online):
        assert found["mass"].value == pytest.approx(MASS, rel=0.03)
        assert found["load_slosh.mass"].value == pytest.approx(SLOSH, rel=0.1)
        for name, truth in (("mass", MASS), ("load_slosh.mass", SLOSH)):
            assert abs(found[name].value - truth) < 4 * found[name].std
