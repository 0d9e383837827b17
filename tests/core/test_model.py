"""CartModel as an assembly: structure, inverse dynamics, partials of whole carts, sensors, leading axes."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import (
    CasterRealignment,
    Contribution,
    ExternalPush,
    FloorPatch,
    FloorSlope,
    ForceBias,
    ForceEffect,
    ForceMisalignment,
    ForceScale,
    Parameter,
    PayloadChange,
    RollingResistance,
    ViscousDrag,
)
from cartgrasp.errors import UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.rigid_body import regressor_b

from .differences import assert_partials
from .drawn import (
    CONSTRAINTS,
    SHOPPING_CART,
    inertias,
    no_wheel_just_lifts,
    numbers,
    poses,
    vectors,
    velocities,
    wrenches,
)

EFFECTS = (
    ViscousDrag(3.0, 1.2),
    RollingResistance(0.02),
    FloorSlope(0.02, -0.01),
    CasterRealignment(0.3),
    PayloadChange(2.0, 5.0, 0.3, -0.1),
    FloorPatch(-1.0, 1.0, -1.0, 1.0, 0.05),
    ExternalPush(1.0, 2.0, 15.0, 3.0),
    CasterRealignment(0.1, 0.07, label="stiff"),
    ForceBias(1.0, -2.0, 0.3),
)
INERTIA = Inertia(24.0, (0.36, 0.05), 2.0)
CART = CartModel(INERTIA, effects=EFFECTS, wheels=SHOPPING_CART)
every_cart = pytest.mark.parametrize("constraints", CONSTRAINTS.values(), ids=CONSTRAINTS.keys())


@st.composite
def states(draw, cart):
    state = cart.state(draw(poses()), draw(velocities(cart.constraints.n_free)))
    state[cart.memory_slice] = draw(vectors(len(cart.memory_names), -3.0, 3.0))
    return state


@every_cart
@given(data=st.data(), inertia=inertias(), wrench_b=wrenches(), time=numbers(0, 4))
def test_partials_of_the_rate(constraints, data, inertia, wrench_b, time):
    cart = CartModel(inertia, constraints, EFFECTS, SHOPPING_CART)
    assume(no_wheel_just_lifts(cart.phi_at(time), cart.wheel_set))
    assume(abs(time - 2.0) > 1e-3)  # the payload jumps on
    state = data.draw(states(cart))
    rate = cart.rate(state, wrench_b, time=time)
    without = cart.state_rate(state, wrench_b, time=time)
    np.testing.assert_allclose(without, rate.value, rtol=1e-12, atol=1e-12)
    scale = 5.0  # an acceleration is a wrench over an inertia of at least 0.2 kg m²
    assert_partials(rate.by_state / scale, lambda s: cart.rate(s, wrench_b, time=time).value / scale, state)
    assert_partials(rate.by_wrench, lambda w: cart.rate(state, w, time=time).value, wrench_b)
    by_parameters = np.delete(rate.by_parameters, _sentinels(cart), axis=-1)

    def value(moved):
        parameters = np.broadcast_to(cart.parameters, (*moved.shape[:-1], len(cart.parameters))).copy()
        parameters[..., np.delete(np.arange(len(cart.parameters)), _sentinels(cart))] = moved
        return cart.rate(state, wrench_b, parameters, time).value / scale

    assert_partials(by_parameters / scale, value, np.delete(cart.parameters, _sentinels(cart)))


def _sentinels(cart):
    """A trail of 0 stands for the listed one: not a number to differentiate by."""
    return [
        i for i, (n, v) in enumerate(zip(cart.parameter_names, cart.parameters, strict=True)) if "trail" in n and v == 0
    ]


@every_cart
@given(data=st.data(), inertia=inertias(), wrench_b=wrenches(), time=numbers(0, 4))
def test_inverse_dynamics_undo_forward_dynamics(constraints, data, inertia, wrench_b, time):
    cart = CartModel(inertia, constraints, EFFECTS, SHOPPING_CART)
    state = data.draw(states(cart))
    acceleration = cart.rate(state, wrench_b, time=time).value[cart.velocity_slice]
    reduced = cart.required_wrench(state, acceleration, time=time)
    # what cancels is up to 1e3 N, of masses whose solve has condition 1e3
    np.testing.assert_allclose(reduced, wrench_b @ cart.basis_b, atol=1e-8)
    again = cart.rate(state, cart.planar_wrench(reduced), time=time).value[cart.velocity_slice]
    np.testing.assert_allclose(again, acceleration, rtol=1e-8, atol=1e-8)


@every_cart
@given(inertia=inertias(), nu=vectors(3, -2, 2), nu_rate=vectors(3, -2, 2))
def test_regressor_times_phi_is_inverse_dynamics(constraints, inertia, nu, nu_rate):
    cart = CartModel(inertia, constraints)
    nu, nu_rate = nu[: constraints.n_free], nu_rate[: constraints.n_free]
    Y = regressor_b(nu @ cart.basis_b.T, nu_rate @ cart.basis_b.T)
    expected = cart.required_wrench(cart.state(velocity=nu), nu_rate)
    np.testing.assert_allclose(cart.basis_b.T @ Y @ inertia.phi, expected, atol=1e-11)


@given(values=vectors(4, -0.05, 0.05))
def test_with_parameters_round_trip(values):
    parameters = CART.parameters.copy()
    parameters[:4] *= 1 + values
    again = CART.with_parameters(parameters)
    np.testing.assert_allclose(again.parameters, parameters, rtol=1e-13, atol=1e-13)
    assert again.parameter_names == CART.parameter_names
    assert [e.key for e in again.effects] == [e.key for e in CART.effects]
    assert replace(again, inertia=CART.inertia) == CART


def test_names_follow_the_parts():
    assert CART.parameter_names[:6] == (
        "m",
        "m_dx",
        "m_dy",
        "J",
        "viscous_drag.linear",
        "viscous_drag.angular",
    )
    assert "caster_realignment.stiff.swivel_torque" in CART.parameter_names
    assert len(CART.parameter_names) == len(CART.parameters)
    assert CART.state_names == (
        *("x", "y", "theta", "u", "r"),
        *("caster1.heading", "caster2.heading"),
    )
    assert len(CART.state()) == len(CART.state_names)


def test_effects_come_and_go_by_key():
    bare = CartModel(INERTIA)
    dragged = bare.with_effect(ViscousDrag(3.0)).with_effect(ForceBias(1.0, label="left"))
    assert dragged.without_effect("force_bias.left").without_effect("viscous_drag") == bare
    with pytest.raises(UsageError, match=r"has no force_bias; it has viscous_drag, force_bias\.left"):
        dragged.without_effect("force_bias")
    with pytest.raises(UsageError, match="viscous_drag stands twice"):
        dragged.with_effect(ViscousDrag(1.0))


@every_cart
@given(nu=vectors(3, -2, 2))
def test_free_velocities_span_what_the_constraints_allow(constraints, nu):
    """The axle's middle does not move across its wheels, and what is on a rail does not turn."""
    nu = nu[: constraints.n_free]
    assert constraints.basis_b.shape == (3, 3 - constraints.n_rows)
    assert np.linalg.matrix_rank(constraints.basis_b) == constraints.n_free
    u, w, r = constraints.basis_b @ nu
    if constraints.axle_x is not None:
        across = -np.sin(constraints.angle) * u + np.cos(constraints.angle) * (w + constraints.axle_x * r)
        assert across == pytest.approx(0.0, abs=1e-14)
    assert not constraints.no_rotation or r == 0
    np.testing.assert_allclose(constraints.free_velocity(constraints.basis_b @ nu), nu)
    assert len(constraints.velocity_names) == constraints.n_free


@pytest.mark.parametrize(
    ("values", "words"),
    [((None, True), "no_rotation needs no_lateral_slip"), ((np.nan, False), "axle_x: nan is not a number")],
)
def test_constraints_that_cannot_be_are_refused(values, words):
    with pytest.raises(UsageError, match=words):
        RollingConstraints(*values)


# --- sensors ------------------------------------------------------------------------------------------------

SENSORS = (
    ForceScale(1.1),
    ForceMisalignment(0.1, label="left"),
    ForceBias(1.0, -2.0, 0.3, label="left"),
    ForceBias(9.0, 9.0, 9.0, label="right"),
    ForceScale(0.8, label="left"),
)
MEASURED = CartModel(INERTIA, effects=SENSORS)


@given(wrench=vectors(6, -80, 80))
def test_a_chain_of_sensor_effects(wrench):
    """By hand: 0.8 (Rz(-0.1) 1.1 F + bias) for the left arm, 1.1 F + 9 for the right one; and back."""
    turn = np.exp(-0.1j)
    force, moment = complex(*wrench[:2]) * turn, complex(*wrench[3:5]) * turn
    turned = np.array([force.real, force.imag, wrench[2], moment.real, moment.imag, wrench[5]])
    left = 0.8 * (1.1 * turned + np.array([1.0, -2.0, 0, 0, 0, 0.3]))
    np.testing.assert_allclose(MEASURED.recorded_wrench("left", wrench), left, atol=1e-12)
    right = 1.1 * wrench + np.array([9.0, 9.0, 0, 0, 0, 9.0])
    np.testing.assert_allclose(MEASURED.recorded_wrench("right", wrench), right, atol=1e-12)
    for arm, recorded in (("left", left), ("right", right)):
        np.testing.assert_allclose(MEASURED.corrected_wrench(arm, recorded)[0], wrench, atol=1e-11)


@pytest.mark.parametrize("arm", ["left", "right", "third"])
@given(wrench=vectors(6, -80, 80))
def test_partials_of_a_chain_of_sensor_effects(arm, wrench):
    _, by_parameters = MEASURED.corrected_wrench(arm, wrench)
    assert_partials(by_parameters, lambda p: MEASURED.corrected_wrench(arm, wrench, p)[0], MEASURED.parameters)


def test_sensors_broadcast_wrenches_against_parameters():
    generator = np.random.default_rng(3)
    wrenches_a = generator.normal(size=(5, 6))
    parameters = MEASURED.parameters * generator.uniform(0.9, 1.1, (4, 1, len(MEASURED.parameters)))
    value, by_parameters = MEASURED.corrected_wrench("left", wrenches_a, parameters)
    assert value.shape == (4, 5, 6)
    for i in range(4):
        for j in range(5):
            one, one_by = MEASURED.corrected_wrench("left", wrenches_a[j], parameters[i, 0])
            np.testing.assert_allclose(value[i, j], one, atol=1e-12)
            np.testing.assert_allclose(by_parameters[i, j], one_by, atol=1e-12)


# --- leading axes -------------------------------------------------------------------------------------------

_generator = np.random.default_rng(4)
STACKS = {
    "state": CART.state((0.2, 0.1, 0.3), [0.5, -0.2]) + 0.1 * _generator.normal(size=(3, len(CART.state()))),
    "wrench_b": _generator.normal(size=(3, 3)) * 20,
    "parameters": CART.parameters * _generator.uniform(0.95, 1.05, (3, len(CART.parameters))),
    "time": np.array([0.5, 1.5, 2.5]),
}
ONE = {
    "state": STACKS["state"][0],
    "wrench_b": STACKS["wrench_b"][0],
    "parameters": CART.parameters,
    "time": 1.0,
}


@pytest.mark.parametrize("stacked", [[name] for name in STACKS] + [list(STACKS)], ids=lambda names: "+".join(names))
def test_the_rate_broadcasts_over_any_argument(stacked):
    together = CART.rate(**{**ONE, **{name: STACKS[name] for name in stacked}})
    for i in range(3):
        alone = CART.rate(**{**ONE, **{name: STACKS[name][i] for name in stacked}})
        for name in ("value", "by_state", "by_wrench", "by_parameters"):
            np.testing.assert_allclose(getattr(together, name)[i], getattr(alone, name), rtol=1e-11, atol=1e-11)
    without = CART.state_rate(**{**ONE, **{name: STACKS[name] for name in stacked}})
    np.testing.assert_allclose(without, together.value, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("stacked", ["state", "parameters", "time"])
def test_effect_wrench_and_inverse_dynamics_broadcast(stacked):
    arguments = {name: ONE[name] for name in ("state", "parameters", "time")}
    together = CART.effect_wrench(**{**arguments, stacked: STACKS[stacked]})
    required = CART.required_wrench(acceleration=np.array([0.3, -0.2]), **{**arguments, stacked: STACKS[stacked]})
    for i in range(3):
        one = {**arguments, stacked: STACKS[stacked][i]}
        np.testing.assert_allclose(together[i], CART.effect_wrench(**one), rtol=1e-12)
        alone = CART.required_wrench(acceleration=np.array([0.3, -0.2]), **one)
        np.testing.assert_allclose(required[i], alone, rtol=1e-11, atol=1e-11)


def test_memories_beside_an_effect_without_a_kernel_are_those_without_it():
    """Along a given motion; what has a memory of its own, or changes the body, goes step by step."""

    class Wind(ForceEffect):
        name: ClassVar[str] = "wind_of_the_test"
        parameters: ClassVar[tuple[Parameter, ...]] = ()

        def wrench_b(self, situation, memory, parameters):
            value = np.zeros((*situation.velocity_b.shape[:-1], 3))
            value[..., 0] = -1.0
            return Contribution(value)

    time = np.arange(0.0, 4.0, 0.01)
    cart = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(CasterRealignment(0.2, 0.05),))
    velocity = np.column_stack([0.6 * np.cos(time), 0.4 * np.sin(2.0 * time)])
    pose = np.column_stack([np.cumsum(velocity[:, 0]) * 0.01, np.zeros_like(time), np.cumsum(velocity[:, 1]) * 0.01])
    beside = cart.with_effect(Wind())
    assert not beside.is_compiled
    found = beside.memory_along(pose, velocity, time)
    np.testing.assert_array_equal(found, cart.memory_along(pose, velocity, time))
    other = beside.parameters * 1.1
    expected = cart.with_parameters(cart.parameters * 1.1).memory_along(pose, velocity, time)
    np.testing.assert_allclose(beside.memory_along(pose, velocity, time, other), expected, rtol=1e-12, atol=1e-12)
