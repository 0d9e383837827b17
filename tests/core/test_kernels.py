"""What stands between the kernels and those who call them: the rigid body that they mirror, inverse dynamics with
partials, effects from outside the library, and the steps of the plant."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cartgrasp.compiling import digest
from cartgrasp.contacts import ContactWrenches
from cartgrasp.effects import (
    KNOWN_EFFECTS,
    CasterRealignment,
    ExternalPush,
    PayloadChange,
    RollingResistance,
    UnknownSlope,
    ViscousDrag,
)
from cartgrasp.effects.compiled import CompiledForce, CompiledInertia
from cartgrasp.effects.effect import Contribution, ForceEffect, InertiaEffect, Parameter, Situation
from cartgrasp.errors import UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.kernels import entries, jit, rigid_body, vocabulary
from cartgrasp.kernels.vocabulary import KINDS
from cartgrasp.kernels.workspace import PackedEffect, pack
from cartgrasp.model import CartModel
from cartgrasp.rigid_body import bias_b, mass_matrix_b, regressor_b
from cartgrasp.simulation.integrate import held, runge_kutta_4
from cartgrasp.simulation.plant import ModelPlant
from tests.kernels_called import kept

from .differences import assert_partials
from .drawn import SHOPPING_CART, inertias, no_wheel_just_lifts, numbers, phis, vectors, velocities, wrenches
from .test_model import CART, EFFECTS, every_cart, states

ROOT = Path(__file__).parents[2]
AT_REST = Situation(0.0, np.zeros(3), np.zeros(3), CART.inertia.phi, CART.wheel_set)


@given(phi=phis(), velocity=velocities(), acceleration=vectors(3, -3.0, 3.0))
def test_the_rigid_body_of_the_kernels_is_that_of_the_house(phi, velocity, acceleration):
    twist, rate = tuple(velocity), tuple(acceleration)
    np.testing.assert_array_equal(rigid_body.regressor.py_func(twist, rate), regressor_b(velocity, acceleration))
    np.testing.assert_array_equal(rigid_body.mass_matrix.py_func(phi), mass_matrix_b(phi))
    np.testing.assert_allclose(rigid_body.by_velocity.py_func(twist, phi), bias_b(velocity, phi)[1], atol=1e-13)
    most, by_phi = rigid_body.most_swinging.py_func(phi)
    assert most == pytest.approx(_most_swinging(phi)[0], rel=1e-6)
    assert_partials(np.array(by_phi), _most_swinging, phi)


def _most_swinging(phi):
    return 0.95 / np.linalg.inv(mass_matrix_b(phi))[..., 0, :1]


# --- inverse dynamics ---------------------------------------------------------------------------------------


@every_cart
@given(data=st.data(), inertia=inertias(), time=numbers(0, 4))
def test_inverse_dynamics_with_partials(constraints, data, inertia, time):
    """Values against forward dynamics, by way of the numpy mass matrix; partials against differences."""
    cart = CartModel(inertia, constraints, EFFECTS, SHOPPING_CART)
    assume(no_wheel_just_lifts(cart.phi_at(time), cart.wheel_set))
    assume(abs(time - 2.0) > 1e-3)  # the payload jumps on
    state = data.draw(states(cart))
    acceleration = data.draw(vectors(cart.constraints.n_free, -3.0, 3.0))
    found = cart.inverse(state, acceleration, time=time)

    forward = cart.rate(state, np.zeros(3), time=time)
    mass = cart.basis_b.T @ mass_matrix_b(cart.phi_at(time)) @ cart.basis_b
    expected = mass @ (acceleration - forward.value[cart.velocity_slice])
    np.testing.assert_allclose(found.wrench, expected, rtol=1e-9, atol=1e-8)
    np.testing.assert_allclose(found.by_acceleration, mass, rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(found.memory_rate, forward.value[cart.memory_slice])

    assert_partials(found.by_state, lambda s: cart.inverse(s, acceleration, time=time).wrench, state)
    assert_partials(found.memory_rate_by_state, lambda s: cart.inverse(s, acceleration, time=time).memory_rate, state)
    known = [i for i, name in enumerate(cart.parameter_names) if "trail" not in name or cart.parameters[i] > 0]

    def moved(values):
        parameters = np.broadcast_to(cart.parameters, (*values.shape[:-1], len(cart.parameters))).copy()
        parameters[..., known] = values
        return cart.inverse(state, acceleration, parameters, time)

    at = cart.parameters[known]
    assert_partials(found.by_parameters[:, known], lambda values: moved(values).wrench, at)
    assert_partials(found.memory_rate_by_parameters[:, known], lambda values: moved(values).memory_rate, at)


def test_inverse_dynamics_broadcast():
    generator = np.random.default_rng(2)
    states_ = CART.state(velocity=[0.5, 0.1]) + 0.1 * generator.normal(size=(4, 1, len(CART.state())))
    accelerations = generator.normal(size=(3, 2))
    together = CART.inverse(states_, accelerations, time=2.5)
    for i, j in np.ndindex(4, 3):
        alone = CART.inverse(states_[i, 0], accelerations[j], time=2.5)
        for name, value in vars(alone).items():
            np.testing.assert_array_equal(getattr(together, name)[i, j], value)


def test_what_parameters_change_alone_is_that_of_all_partials():
    generator = np.random.default_rng(3)
    states_ = CART.state(velocity=[0.5, 0.1]) + 0.1 * generator.normal(size=(7, len(CART.state())))
    accelerations = generator.normal(size=(7, 2))
    whole = CART.inverse(states_, accelerations, time=2.5)
    wrench, by_parameters = CART.inverse_by_parameters(states_, accelerations, time=2.5)
    np.testing.assert_array_equal(wrench, whole.wrench)
    np.testing.assert_array_equal(by_parameters, whole.by_parameters)
    with pytest.raises(UsageError, match="acceleration has 3 numbers, but this cart's has 2"):
        CART.inverse_by_parameters(states_[0], np.zeros(3))


@pytest.mark.long
def test_another_packages_kernel_may_call_it():
    """It counts references, as kernels here do not."""

    @kept
    def wrench_after(floats, ints, given, found):
        total = np.zeros(2)
        for _ in range(100):
            moved = given.copy()
            moved[0, 3] += 0.1
            entries.inverses(floats, ints, moved, found)
            total += found[0, :2] / 100
        return total

    state, acceleration = CART.state(velocity=[0.5, 0.1]), np.array([0.3, -0.2])
    n, p, f, k = len(state), len(CART.parameters), 2, len(CART.memory_names)
    given_ = np.concatenate([state, [2.5], CART.parameters, acceleration])[None]
    found = np.empty((1, f * (1 + n + f + p) + k * (1 + n + p)))
    held_ = CART.dynamics.floats, CART.dynamics.ints, given_, found
    before = [sys.getrefcount(array) for array in held_]
    total = wrench_after(*held_)
    assert [sys.getrefcount(array) for array in held_] == before
    state[3] += 0.1
    expected = CART.inverse(state, acceleration, time=2.5)
    np.testing.assert_allclose(total, expected.wrench, rtol=1e-12)
    parts = np.concatenate([part.ravel() for part in vars(expected).values()])
    np.testing.assert_array_equal(found[0], parts)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: CART.rate(np.zeros(5), np.zeros(3)), r"state has 5 numbers .* have 7 and \d+"),
        (lambda: CART.rate(CART.state(), np.zeros(3), np.zeros(4)), r"parameters 4, but"),
        (lambda: CART.rate(CART.state(), np.zeros(2)), "wrench has 2 numbers"),
        (lambda: CART.required_wrench(CART.state(), np.zeros(3)), "acceleration has 3 numbers"),
        (lambda: EFFECTS[3].wrench_b(AT_REST, np.zeros(3), EFFECTS[3].values), r"\(3, 5\) numbers, but \(2, 5\)"),
        (lambda: EFFECTS[4].phi_change(0.0, np.zeros(3)), "payload_change: 3 parameters, but 4 are needed"),
    ],
)
def test_arrays_of_another_cart_are_refused(call, words):
    """Kernels look at no bounds."""
    with pytest.raises(UsageError, match=words):
        call()


# --- effects from outside the library -----------------------------------------------------------------------


@dataclass(frozen=True)
class Lag(ForceEffect):
    """Drag `linear` times (u, w), and a memory that follows u at `speed` and pulls back."""

    linear: float = 4.0
    speed: float = 2.0

    name: ClassVar[str] = "lag"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("linear", "N·s/m", 1.0), Parameter("speed", "1/s", 1.0))
    signature: ClassVar[str] = "a drag that comes late"

    def memory_names(self, wheels):
        return ("lag.slow",)

    def wrench_b(self, situation, memory, parameters):
        linear = parameters[..., 0, None]
        pull = -linear * (situation.velocity_b * [1.0, 1.0, 0.0]) - memory * [1.0, 0.0, 0.0]
        by_parameters = np.zeros((*pull.shape, 2))
        by_parameters[..., 0] = -situation.velocity_b * [1.0, 1.0, 0.0]
        return Contribution(
            pull,
            by_velocity=-linear[..., None] * np.diag([1.0, 1.0, 0.0]),
            by_memory=np.broadcast_to([[-1.0], [0.0], [0.0]], (*pull.shape, 1)),
            by_parameters=by_parameters,
        )

    def memory_rate(self, situation, memory, parameters):
        speed, gap = parameters[..., 1, None], situation.velocity_b[..., :1] - memory
        by_velocity = speed[..., None] * np.array([[1.0, 0.0, 0.0]])
        by_parameters = np.concatenate([np.zeros_like(gap), gap], axis=-1)[..., None, :]
        return Contribution(
            speed * gap, by_velocity=by_velocity, by_memory=-speed[..., None], by_parameters=by_parameters
        )

    def stiction(self, situation, memory, parameters):
        return np.array([[2.0], [0.0], [0.0]])

    def settled_memory(self, situation, memory):
        return situation.velocity_b[..., :1]


@dataclass(frozen=True)
class Ballast(InertiaEffect):
    """A mass at (0.3, -0.1)."""

    mass: float = 5.0

    name: ClassVar[str] = "ballast"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("mass", "kg", 1.0),)
    signature: ClassVar[str] = "heavier"
    shape: ClassVar[tuple[float, ...]] = (1.0, 0.3, -0.1, 0.1)

    def phi_change(self, time, parameters):
        value = parameters * self.shape
        return Contribution(value, by_parameters=np.broadcast_to(np.array(self.shape)[:, None], (*value.shape, 1)))


BETWEEN = (ViscousDrag(3.0, 1.2), RollingResistance(0.02))
OURS = CartModel(
    Inertia(24.0, (0.36, 0.05), 2.0),
    effects=(*BETWEEN, PayloadChange(-1.0, 5.0, 0.3, -0.1), CasterRealignment(0.3)),
    wheels=SHOPPING_CART,
)


def test_a_foreign_change_of_inertia_counts_like_our_own():
    """Ballast is a payload; what others make of phi (loads of wheels) follows."""
    theirs = replace(OURS, effects=(*BETWEEN, Ballast(), CasterRealignment(0.3)))
    state, wrench_b = OURS.state((0.1, 0.2, 0.3), [0.4, 0.2]), np.array([10.0, 1.0, 2.0])
    state[OURS.memory_slice] = 0.4, -1.0
    same = [OURS.parameter_names.index(name) for name in OURS.parameter_names if "payload" not in name]
    mine = [theirs.parameter_names.index(OURS.parameter_names[i]) for i in same]
    for states_ in (state, state + np.linspace(0, 0.1, 3)[:, None]):
        one, other = OURS.rate(states_, wrench_b), theirs.rate(states_, wrench_b)
        np.testing.assert_allclose(other.value, one.value, rtol=1e-12)
        np.testing.assert_allclose(other.by_state, one.by_state, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(other.by_parameters[..., mine], one.by_parameters[..., same], atol=1e-12)
        mass = OURS.parameter_names.index("payload_change.mass"), theirs.parameter_names.index("ballast.mass")
        np.testing.assert_allclose(other.by_parameters[..., mass[1]], one.by_parameters[..., mass[0]], atol=1e-12)
    np.testing.assert_allclose(theirs.phi_at(0.0), OURS.phi_at(0.0))
    np.testing.assert_allclose(
        theirs.stiction(state, theirs.parameters), OURS.stiction(state, OURS.parameters), atol=1e-12
    )


@pytest.mark.long
@every_cart
@given(data=st.data(), wrench_b=wrenches())
def test_a_foreign_force_has_all_that_ours_have(constraints, data, wrench_b):
    cart = CartModel(Inertia(24.0, (0.36, 0.05), 2.0), constraints, (Ballast(), CasterRealignment(0.3, 0.05), Lag()))
    state = data.draw(states(cart))
    rate = cart.rate(state, wrench_b)
    np.testing.assert_array_equal(cart.state_rate(state, wrench_b), rate.value)
    assert_partials(rate.by_state, lambda s: cart.rate(s, wrench_b).value, state)
    assert_partials(rate.by_parameters, lambda p: cart.rate(state, wrench_b, p).value, cart.parameters)
    acceleration = rate.value[cart.velocity_slice]
    np.testing.assert_allclose(cart.required_wrench(state, acceleration), wrench_b @ cart.basis_b, atol=1e-8)
    velocity_b = cart.basis_b @ state[cart.velocity_slice]
    assert cart.stiction(state, cart.parameters)[:, -1].tolist() == [2.0 * math.sqrt(0.1 / 3.0), 0.0, 0.0]
    assert cart.settled_memory(state, cart.parameters)[-1] == velocity_b[0]
    alone = CartModel(cart.inertia, constraints, (CasterRealignment(0.3, 0.05),))
    drag = cart.effect_wrench(state) - alone.effect_wrench(state[:-1])
    np.testing.assert_allclose(drag, -4.0 * velocity_b * [1, 1, 0] - state[-1] * np.eye(3)[0], atol=1e-9)


# --- steps --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("effects", [EFFECTS, (Lag(), *EFFECTS[:4])], ids=["compiled", "with a foreign one"])
def test_steps_are_runge_kuttas(effects):
    """While a push begins and a payload comes on; against four calls of the rate a step."""
    cart = CartModel(
        Inertia(24.0, (0.36, 0.05), 2.0), effects=(*effects, ExternalPush(0.02, 0.01, 8.0, 1.0, label="b"))
    )
    state, wrench_b, step = cart.state((0.1, 0.2, 0.3), [0.4, 0.2]), np.array([10.0, 1.0, 2.0]), 0.004
    ended = held(cart, state, wrench_b, 1.99, (step, 7))
    for k in range(7):
        state = runge_kutta_4(lambda t, y: cart.state_rate(y, wrench_b, time=t), 1.99 + k * step, state, step)
    np.testing.assert_allclose(ended, state, rtol=1e-12, atol=1e-13)


def test_a_plant_with_a_foreign_effect_moves():
    plant = ModelPlant(CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(Lag(speed=0.0),)))
    push = ContactWrenches({"a": np.array([8.0, 0, 0, 0, 0, 0])}, {"a": np.zeros(3)})
    for _ in range(100):
        plant.step(push, 0.01)
    assert plant.motion.velocity[0] == pytest.approx(8.0 / 4.0 * (1 - np.exp(-4.0 / 24.0)), rel=1e-9)


# --- the compiled code --------------------------------------------------------------------------------------


def test_every_kernel_has_its_own_number():
    assert len(set(KINDS.values())) == len(KINDS)
    with pytest.raises(UsageError, match="glue has no kernel"):
        pack(
            [PackedEffect("glue", slice(4, 4), slice(0, 0))],
            (np.eye(3), np.eye(3)),
            np.eye(3),
            (0, 4),
            (9.81, 0.1),
        )


def test_a_compiled_effect_has_a_file_of_kernels_and_these_have_names_that_are_called():
    compiled = [
        one for one in (*KNOWN_EFFECTS.values(), UnknownSlope) if issubclass(one, CompiledForce | CompiledInertia)
    ]
    assert {one.name for one in compiled} == set(KINDS)
    for name, module in vocabulary.KERNELS.items():
        mine = {what for what, one in vars(module).items() if getattr(one, "__module__", None) == module.__name__}
        kernels = {what for what in mine if hasattr(getattr(module, what), "py_func") and not what.startswith("_")}
        assert kernels <= {"wrench", "memory_rate", "stiction", "settled", "phi_change"}, name
        assert kernels & {"wrench", "phi_change"}, name


def test_the_cached_kernels_carry_the_digest():
    assert entries.rates.py_func.__qualname__ == f"rates_{jit.DIGEST}"
    assert digest([b"a = 1\n", b"b = 2\n"]) != digest([b"a = 1\n", b"b = 3\n"])


def test_making_a_cart_imports_no_kernel():
    code = (
        "import sys; from cartgrasp import CartModel, Inertia; from cartgrasp.effects import ViscousDrag;"
        "CartModel(Inertia(20.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(3.0),)).parameters;"
        "print([m for m in sys.modules if m == 'numba' or m.startswith('cartgrasp.kernels')])"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    assert done.stdout.strip() == "[]"
