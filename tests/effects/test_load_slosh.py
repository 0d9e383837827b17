"""Part of the load that swings, against two masses on a spring: closed forms, energy, momentum, an own simulation and
fits to it; and what is of the whole cart, against the cart without the effect."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cartgrasp.cart_file import cart_from_text, cart_text
from cartgrasp.constraints import RollingConstraints
from cartgrasp.contacts import ContactWrenches
from cartgrasp.effects import (
    CasterRealignment,
    FloorSlope,
    LateralSlip,
    LoadSlosh,
    PayloadChange,
    RollingResistance,
    ViscousDrag,
    WheelMisalignment,
)
from cartgrasp.effects.effect import SMOOTHING_SPEED
from cartgrasp.errors import FileError
from cartgrasp.floor_reaction import FloorReaction
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.rigid_body import bias_b, mass_matrix_b
from cartgrasp.simulation.plant import ModelPlant
from estimation import CartFilter, FilterNoise
from estimation.whole_log.identification import identify
from estimation.whole_log.replay import replay
from tests.core.differences import assert_partials
from tests.core.drawn import CONSTRAINTS, SHOPPING_CART, numbers, vectors
from tests.estimation.runs import CONTACT, STEP, push, record

MASS, SLOSH = 20.0, 6.0


def cart(*effects, constraints=RollingConstraints(), **parts):
    return CartModel(Inertia(MASS, (0.3, 0.1), 2.0), constraints, effects, **parts)


@given(mass=numbers(0.5, 15), frequency=numbers(0.2, 3), force=numbers(-50, 50), time=numbers(0.1, 3))
def test_two_masses_on_a_spring_under_a_step_of_force(mass, frequency, force, time):
    """Without damping, s = -(F / M) (1 - cos w t) / w² with w² = omega² (1 + ms / M), M what does not swing; and the
    momentum of both is F t."""
    model = cart(LoadSlosh(mass, frequency, 0.0), constraints=RollingConstraints(0.0, no_rotation=True))
    run = solve_ivp(
        lambda _, s: model.state_rate(s, np.array([force, 0.0, 0.0])), (0, time), model.state(), rtol=1e-9, atol=1e-11
    )
    u, stretch, speed = run.y[3:, -1]
    rest = MASS - mass
    w = 2 * np.pi * frequency * np.sqrt(1 + mass / rest)
    expected = -force / rest * (1 - np.cos(w * time)) / w**2
    rate = -force / rest * np.sin(w * time) / w
    assert stretch == pytest.approx(expected, rel=1e-6, abs=1e-7)
    assert u == pytest.approx((force * time - mass * rate) / MASS, rel=1e-6, abs=1e-7)
    assert speed - u == pytest.approx(rate, rel=1e-6, abs=1e-6)


@given(mass=numbers(0.5, 15), frequency=numbers(0.2, 3), damping=numbers(0, 1), nu=vectors(2, -1, 1))
def test_only_its_damper_takes_energy(mass, frequency, damping, nu):
    """d/dt (the rest + ms v²/2 + ms omega² s²/2) = power of the arms - 2 ms zeta omega (v - u)², also while turning."""
    model, omega = cart(LoadSlosh(mass, frequency, damping)), 2 * np.pi * frequency
    state = model.state((0.1, 0.2, 0.3), nu)
    state[model.memory_slice] = 0.04, nu[0] + 0.3
    wrench_b = np.array([10.0, 3.0, -4.0])
    rate = model.state_rate(state, wrench_b)
    m, (dx, dy), inertia = MASS, (0.3, 0.1), 2.0
    matrix = np.array([[m - mass, -m * dy], [-m * dy, inertia + m * (dx**2 + dy**2)]])
    to_rest = nu @ matrix @ rate[3:5]
    stretch, speed = state[5:]
    to_load = mass * speed * rate[6] + mass * omega**2 * stretch * rate[5]
    lost = 2 * mass * damping * omega * (speed - nu[0]) ** 2
    assert to_rest + to_load == pytest.approx(nu @ wrench_b[[0, 2]] - lost, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("constraints", CONSTRAINTS.values(), ids=CONSTRAINTS.keys())
def test_while_it_goes_along_nothing_is_to_be_seen_of_it(constraints):
    """Under a steady acceleration, with s = -u' / omega², the wrench is that of the cart without the effect."""
    others = FloorSlope(0.03, -0.02), RollingResistance(0.02), ViscousDrag(3.0, 1.0), PayloadChange(0.5, 4.0, 0.2, 0.1)
    model, bare = (
        cart(*others, *swings, constraints=constraints, wheels=SHOPPING_CART) for swings in ((LoadSlosh(SLOSH),), ())
    )
    nu, rate = np.array([0.4, 0.3, -0.2])[: constraints.n_free], np.array([0.6, -0.5, 0.8])[: constraints.n_free]
    state = model.state((1.0, 2.0, 0.7), nu)
    state[model.state_names.index("load_slosh.displacement")] = -(model.basis_b @ rate)[0] / (2 * np.pi * 1.0) ** 2
    alone = bare.required_wrench(bare.state((1.0, 2.0, 0.7), nu), rate, time=1.0)
    np.testing.assert_allclose(model.required_wrench(state, rate, time=1.0), alone, rtol=1e-12)


def test_it_weighs_on_the_floor_as_what_lies_still():
    others = FloorSlope(0.03, -0.02), RollingResistance(0.02)
    model, bare = (cart(*others, *swings, wheels=SHOPPING_CART) for swings in ((LoadSlosh(SLOSH, 1.2, 0.2),), ()))
    for turned in (0.0, 0.7):
        rest, lain = model.state((0, 0, turned), (0.5, 0.2)), bare.state((0, 0, turned), (0.5, 0.2))
        np.testing.assert_array_equal(model.effect_wrench(rest), bare.effect_wrench(lain))
    level = (cart(*swings, wheels=SHOPPING_CART, com_height=0.5) for swings in ((LoadSlosh(SLOSH),), ()))
    loads, alone = (FloorReaction.of(one).loads(np.zeros(6)) for one in level)
    assert alone.sum() == pytest.approx(MASS * 9.81)
    np.testing.assert_allclose(loads, alone, rtol=1e-12)


MANY = {"some": 5.0, "as much as goes, and more": 40.0}


@pytest.mark.parametrize("mass", MANY.values(), ids=MANY.keys())
@pytest.mark.parametrize("constraints", CONSTRAINTS.values(), ids=CONSTRAINTS.keys())
@given(data=st.data())
def test_partials_with_accelerations(constraints, mass, data):
    """Of forward and inverse dynamics; beside another that swings, and a load that comes on."""
    effects = LoadSlosh(mass, 0.9, 0.1), LoadSlosh(1.0, 1.5, label="bag"), PayloadChange(0.5, 4.0, 0.2, 0.1)
    model = cart(*effects, RollingResistance(0.02), constraints=constraints, wheels=SHOPPING_CART)
    nu, rate = (data.draw(vectors(constraints.n_free, -2, 2)) for _ in range(2))
    state, push = model.state((0.1, 0.2, 0.3), nu), data.draw(vectors(3, -80, 80))
    state[model.memory_slice] = data.draw(vectors(6, -0.5, 0.5))
    values = model.parameters
    there = model.rate(state, push, time=1.0)
    np.testing.assert_allclose(model.state_rate(state, push, time=1.0), there.value, rtol=1e-12, atol=1e-12)
    if mass < MASS:
        again = model.required_wrench(state, there.value[model.velocity_slice], time=1.0)
        np.testing.assert_allclose(again, push @ model.basis_b, atol=1e-9)
    size = 1 + np.abs(there.value).max()  # where hardly anything is left to push, accelerations are large
    for partials, moved, at in (
        (there.by_state, lambda s: model.state_rate(s, push, time=1.0), state),
        (there.by_wrench, lambda w: model.state_rate(state, w, time=1.0), push),
        (there.by_parameters, lambda p: model.state_rate(state, push, p, 1.0), values),
    ):
        assert_partials(partials / size, lambda x, moved=moved: moved(x) / size, at)
    back = model.inverse(state, rate, time=1.0)
    for partials, moved, at in (
        (back.by_state, lambda s: model.required_wrench(s, rate, time=1.0), state),
        (back.by_acceleration, lambda a: model.required_wrench(state, a, time=1.0), rate),
        (back.by_parameters, lambda p: model.required_wrench(state, rate, p, 1.0), values),
    ):
        assert_partials(partials, moved, at)


@given(
    mass=numbers(0, 1000),
    share=numbers(0, 1),
    frequency=numbers(0.1, 3),
    com=vectors(2, -0.5, 0.5),
    nu=vectors(3, -1, 1),
)
def test_whatever_a_fit_tries_something_is_left_to_push(mass, share, frequency, com, nu):
    body = Inertia(MASS, tuple(com), 0.5)
    effects = LoadSlosh(share * mass, frequency), LoadSlosh((1 - share) * mass, label="bag")
    for constraints in CONSTRAINTS.values():
        model = CartModel(body, constraints, effects)
        state = model.state(velocity=nu[: constraints.n_free])
        rate = model.rate(state, np.array([10.0, 3.0, -4.0]))
        assert np.isfinite(rate.value).all()
        assert np.isfinite(rate.by_parameters).all()
        mobility = rate.by_wrench[model.velocity_slice] @ np.linalg.pinv(model.basis_b.T)
        assert np.linalg.eigvalsh((mobility + mobility.T) / 2).min() > 0
        if constraints.n_free == 3:
            alone = 1 / np.linalg.inv(mass_matrix_b(body.phi))[0, 0]
            assert 1 / mobility[0, 0] == pytest.approx(alone - min(mass, 0.95 * alone), rel=1e-6)


def test_a_cart_file_can_not_say_that_more_swings_than_there_is():
    text = cart_text(cart(LoadSlosh(12.0), LoadSlosh(7.5, label="bag")))
    assert cart_from_text(text) == cart(LoadSlosh(12.0), LoadSlosh(7.5, label="bag"))
    with pytest.raises(
        FileError, match=r"effects\.load_slosh: 20 kg swings on a cart of 20 kg; give `mass` of the cart with"
    ):
        cart_from_text(text.replace("7.5", "8.0"))


@pytest.mark.parametrize("seed", range(3))
def test_creep_of_wheels_at_an_angle_beside_it(seed):
    """lambda across the wheels is what M_b without ms lacks; partials against differences."""
    rng = np.random.default_rng(seed)
    model = cart(LoadSlosh(SLOSH, 0.9, 0.1), WheelMisalignment(0.3), LateralSlip(cornering_stiffness=800.0))
    state, push = model.state((0.1, 0.2, 0.3), rng.uniform(0.2, 1.0, 2)), rng.normal(0, 10, 3)
    state[model.memory_slice] += rng.normal(0, 0.1, 2)
    rate, velocity = model.rate(state, push), model.basis_b @ state[3:5]
    matrix = mass_matrix_b(model.inertia.phi)
    matrix[0, 0] -= SLOSH
    left = matrix @ model.basis_b @ rate.value[3:5] + bias_b(velocity, model.inertia.phi)[0] - push
    left -= model.effect_wrench(state)
    np.testing.assert_allclose(model.basis_b.T @ left, 0.0, atol=1e-9)
    ahead = np.array([np.cos(0.3 + 0.3), np.sin(0.3 + 0.3)])
    creep = np.linalg.solve(np.column_stack([ahead, [-ahead[1], ahead[0]]]), rate.value[:2])[1]
    across = np.array([-np.sin(0.3), np.cos(0.3), 0.0])
    assert creep == pytest.approx(-state[3] / 800.0 * (across @ left), rel=1e-9)
    assert_partials(rate.by_state, lambda s: model.state_rate(s, push), state)
    assert_partials(rate.by_wrench, lambda w: model.state_rate(state, w), push)
    changing = np.arange(7)  # other angles and stiffnesses are other models
    assert_partials(
        rate.by_parameters[:, changing],
        lambda p: model.state_rate(
            state, push, np.concatenate([p, np.broadcast_to(model.parameters[7:], (*p.shape[:-1], 2))], -1)
        ),
        model.parameters[changing],
    )


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


def moved(coefficient, duration=20.0):
    """States and forces of two masses integrated here, one of which is on wheels that bear both, pushed straight on."""
    omega, damping, drag = 2 * np.pi * 0.8, 0.08, 3.0

    def rate(_, state, force):
        _, u, stretch, speed = state
        pull = SLOSH * (omega**2 * stretch + 2 * damping * omega * (speed - u))
        rolling = coefficient * MASS * 9.81 * u / np.hypot(u, SMOOTHING_SPEED)
        return [u, (force - drag * u - rolling + pull) / (MASS - SLOSH), speed - u, -pull / SLOSH]

    state, states, forces = np.zeros(4), [], []
    for k in range(round(duration / STEP)):
        force = push(k * STEP)[0]
        states.append(state)
        forces.append(force)
        state = solve_ivp(rate, (0, STEP), state, args=(force,), rtol=1e-6, atol=1e-9).y[:, -1]
    return np.array(states), np.array(forces)


@pytest.mark.parametrize("coefficient", [0.0, 0.02])
def test_a_simulated_cart_moves_like_two_masses(coefficient):
    states, forces = moved(coefficient, duration=4.0)
    model = CartModel(
        Inertia(MASS, (0.3, 0.0), 2.0),
        effects=(ViscousDrag(3.0, 1.0), RollingResistance(coefficient), LoadSlosh(SLOSH, 0.8, 0.08)),
    )
    plant, found = ModelPlant(model), []
    for force in forces:
        found.append(plant.state)
        plant.step(ContactWrenches({"a": np.array([force, 0, 0, 0, 0, 0])}, {"a": np.zeros(3)}), STEP)
    np.testing.assert_allclose(np.array(found)[:, [0, 3, 5, 6]], states, atol=1e-4)
    assert np.ptp(states[:, 2]) > 0.02


def swung(seed, force_noise, coefficient=0.0):
    states, forces = moved(coefficient)
    motion = np.zeros((len(states), 5))
    motion[:, [0, 3]] = states[:, :2]
    wrench = np.zeros((len(states), 6))
    wrench[:, 0] = forces
    wrench[:, 5] = CONTACT[1] * wrench[:, 0]
    return record(motion, {"hand": (CONTACT, wrench)}, (0.0004, 0.005, force_noise), seed)


@pytest.mark.long
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


@pytest.mark.long
def test_rolling_resistance_is_of_all_that_is_carried():
    """A fit finds the coefficient with the weight of what swings in it, and the mass of the whole."""
    log = swung(seed=4, force_noise=1.0, coefficient=0.02)
    effects = ViscousDrag(2.0, 1.0), RollingResistance(0.01), LoadSlosh(2.0, 0.8, 0.08)
    guess = CartModel(Inertia(24.0, (0.0, 0.0), 2.0), effects=effects)
    found = identify([log], guess, noise=FilterNoise(0.0004, 0.0004, 0.005, 0.005, 1.0, 0.05)).parameters
    truths = (("mass", MASS), ("load_slosh.mass", SLOSH), ("rolling_resistance.coefficient", 0.02))
    for (name, truth), near in zip(truths, (0.02, 0.05, 0.05), strict=True):
        assert found[name].value == pytest.approx(truth, rel=near)
        assert abs(found[name].value - truth) < 4 * found[name].std
