"""Wheels that creep sideways, against the multiplier of the constrained equations and where it takes a cart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cartgrasp.constraints import RollingConstraints
from cartgrasp.contacts import ContactWrenches
from cartgrasp.effects import (
    CasterRealignment,
    FloorSlope,
    LateralSlip,
    PayloadChange,
    QuadraticDrag,
    RollingResistance,
    ViscousDrag,
    WheelMisalignment,
)
from cartgrasp.floor_reaction import FloorReaction
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Motion
from cartgrasp.simulation.plant import ModelPlant
from estimation import CartFilter, FilterNoise
from estimation.whole_log.identification import identify
from tests.core.differences import assert_partials
from tests.core.drawn import SHOPPING_CART, inertias, no_wheel_just_lifts, numbers, poses, vectors, wrenches
from tests.core.test_constrained_dynamics import body_velocity, solve_kkt, to_world
from tests.core.test_kernels import Ballast, Lag
from tests.estimation.runs import STEP, simulate

stiffnesses = numbers(200.0, 20000.0)


@given(
    inertia=inertias(),
    pose=poses(),
    nu=vectors(2, -2, 2),
    wrench_b=wrenches(),
    stiffness=stiffnesses,
    axle=st.sampled_from([0.0, 0.35, -0.6]),
    angle=numbers(-0.3, 0.3),
)
def test_the_axle_creeps_as_the_multiplier_says(inertia, pose, nu, wrench_b, stiffness, axle, angle):
    """Across the wheels, against the floor's force on them, which so never gives energy; accelerations stay."""
    cart = CartModel(inertia, RollingConstraints(axle), (WheelMisalignment(angle),))
    rigid = cart.state_rate(cart.state(pose, nu), wrench_b)
    soft = cart.with_effect(LateralSlip(stiffness)).state_rate(cart.state(pose, nu), wrench_b)
    qd = to_world(pose[2], body_velocity(cart.rolling, nu))
    _, forces = solve_kkt(inertia, cart.rolling, pose[2], qd, to_world(pose[2], wrench_b))
    across = np.array([-np.sin(pose[2] + angle), np.cos(pose[2] + angle)])
    creep = soft - rigid
    expected = -abs(nu[0]) * forces[0] / stiffness * across
    np.testing.assert_allclose(creep[:2], expected, rtol=1e-8, atol=1e-10)
    np.testing.assert_array_equal(creep[2:], 0.0)
    assert forces[0] * (creep[:2] @ across) <= 1e-9


@given(data=st.data(), nu=vectors(2, -2, 2), wrench_b=wrenches(), time=numbers(0, 4))
def test_partials_with_all_that_a_cart_may_have(data, nu, wrench_b, time):
    """Casters' memory, a payload, and effects from outside the library."""
    assume(abs(nu[0]) > 1e-3)  # |v| bends there
    effects = (
        *(QuadraticDrag(2.0), RollingResistance(0.02), FloorSlope(0.01, -0.02), CasterRealignment(0.2, 0.05)),
        *(PayloadChange(-1.0, 5.0, 0.2, 0.1), Ballast(), Lag(), WheelMisalignment(0.1), LateralSlip(800.0)),
    )
    cart = CartModel(Inertia(24.0, (0.3, 0.1), 2.0), RollingConstraints(0.2), effects, SHOPPING_CART)
    assume(no_wheel_just_lifts(cart.phi_at(time), cart.wheel_set))
    state = cart.state((0.3, -0.2, 0.7), nu)
    state[cart.memory_slice] = data.draw(vectors(3, -2.0, 2.0))
    rate = cart.rate(state, wrench_b, time=time)
    np.testing.assert_array_equal(cart.state_rate(state, wrench_b, time=time), rate.value)
    assert_partials(rate.by_state, lambda s: cart.state_rate(s, wrench_b, time=time), state)
    assert_partials(rate.by_wrench, lambda w: cart.state_rate(state, w, time=time), wrench_b)
    known = [i for i, name in enumerate(cart.parameter_names) if name != "payload_change.time"]

    def moved(values):
        parameters = np.broadcast_to(cart.parameters, (*values.shape[:-1], len(cart.parameters))).copy()
        parameters[..., known] = values
        return cart.state_rate(state, wrench_b, parameters, time)

    assert_partials(rate.by_parameters[:, known], moved, cart.parameters[known])


def test_the_force_on_the_wheels_is_that_of_the_floor_reaction():
    """With effects that push sideways too; and stacks give what single states do."""
    effects = (ViscousDrag(3.0, 1.0), FloorSlope(0.02, 0.03), RollingResistance(0.02))
    cart = CartModel(Inertia(24.0, (0.3, 0.1), 2.0), RollingConstraints(0.2), effects, SHOPPING_CART, com_height=0.4)
    soft = cart.with_effect(LateralSlip(500.0))
    random = np.random.default_rng(4)
    states = np.stack([cart.state(random.normal(size=3), random.normal(size=2)) for _ in range(6)])
    pushes = 20 * random.normal(size=(6, 6))
    planar = pushes[:, [0, 1, 5]]
    together = soft.rate(states, planar)
    for i, (state, push) in enumerate(zip(states, pushes, strict=True)):
        creep = (soft.state_rate(state, planar[i]) - cart.state_rate(state, planar[i]))[:2]
        lateral = FloorReaction.of(cart, Motion(state[:3], state[3:5])).lateral(push)
        expected = -abs(state[3]) * lateral / 500.0 * np.array([-np.sin(state[2]), np.cos(state[2])])
        np.testing.assert_allclose(creep, expected, rtol=1e-9, atol=1e-12)
        alone = soft.rate(state, planar[i])
        for name, value in vars(alone).items():
            np.testing.assert_allclose(getattr(together, name)[i], value, rtol=1e-12, atol=1e-12)


@pytest.mark.long
@pytest.mark.parametrize("speed", [0.8, -0.8])
def test_a_push_at_the_axle_drifts_by_its_share_of_the_way(speed):
    """A side force at the axle turns nothing: y = F / C times the way, whichever way it rolls; at rest nothing."""
    cart = CartModel(Inertia(20.0, (0.3, 0.0), 2.0), effects=(LateralSlip(2000.0),))
    side = ContactWrenches({"a": np.array([0, 15.0, 0, 0, 0, 0])}, {"a": np.zeros(3)})
    plant, still = ModelPlant(cart, velocity=[speed, 0.0]), ModelPlant(cart)
    for _ in range(200):
        plant.step(side, 0.01)
        still.step(side, 0.01)
    np.testing.assert_allclose(plant.motion.pose_sb, [2.0 * speed, 15.0 / 2000.0 * 2.0 * 0.8, 0.0], atol=1e-12)
    np.testing.assert_allclose(still.motion.pose_sb, 0.0, atol=1e-12)


@pytest.mark.long
def test_a_circle_widens():
    """With its CoM on the axle a cart on a circle pushes outward with F = m u r, and goes out by u F / C a second."""
    mass, u, r, stiffness, duration = 20.0, 1.0, 0.5, 1000.0, 4.0
    cart = CartModel(Inertia(mass, (0.0, 0.0), 2.0), effects=(LateralSlip(stiffness),))
    plant = ModelPlant(cart, velocity=[u, r])
    idle = ContactWrenches({"a": np.zeros(6)}, {"a": np.zeros(3)})
    for _ in range(round(duration / 0.01)):
        plant.step(idle, 0.01)
    creep, angle = u * mass * u * r / stiffness, r * duration
    # integral of R(theta) (u, -creep)
    expected = [
        u / r * np.sin(angle) + creep / r * (1 - np.cos(angle)),
        u / r * (1 - np.cos(angle)) - creep / r * np.sin(angle),
        angle,
    ]
    np.testing.assert_allclose(plant.motion.pose_sb, expected, atol=1e-8)


def creeping_log(stiffness, seed):
    """A log of a cart whose wheels hold, moved by the creep that its side force would cause."""
    mass, dx, dy = 24.0, 0.3, 0.05
    log, truth = simulate((mass, dx, dy, 2.0, 3.0, 1.0, 0.0), seed, duration=15.0, noise=(0.0004, 0.005, 1.0))
    theta, u, r = truth[:, 2:].T
    side = mass * (u * r + dx * np.gradient(r, STEP) - dy * r**2)  # nobody pushes sideways
    creep = -np.abs(u) * side / stiffness
    moved = np.cumsum(creep[:, None] * np.stack([-np.sin(theta), np.cos(theta)], axis=1), axis=0) * STEP
    pose = log.pose.copy()
    pose[:, :2] += moved
    return replace(log, pose=pose), np.abs(moved).max()


@pytest.mark.long
def test_the_filter_and_a_fit_bear_the_creep():
    log, farthest = creeping_log(600.0, seed=3)
    rigid = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(2.0, 1.0),))
    soft = rigid.with_effect(LateralSlip(600.0))
    noise = FilterNoise(0.0004, 0.0004, 0.005, 0.005, 1.0, 0.05)

    def surprise(cart):
        """Mean of the poses' normalised innovations, at most 1 where they are allowed for; and what is found."""
        estimator, seen = CartFilter(cart, ["hand"], noise=noise), []
        for measurement in log.measurements():
            found = estimator.update(measurement).parameters
            if "pose" in estimator.nis:
                value, size = estimator.nis["pose"]
                seen.append(value / size)
        return np.mean(seen[200:]), found

    (knowing, found), (unaware, _) = surprise(soft), surprise(rigid)
    batch = identify([log], soft, noise=noise).parameters
    assert farthest > 0.01
    assert knowing < 1.1
    assert unaware > 10.0
    truth = {"mass": 24.0, "com_x": 0.3, "com_y": 0.05, "inertia": 2.0}
    for taught in (found, batch):
        assert taught["mass"].value == pytest.approx(24.0, rel=0.02)
        assert all(abs(taught[name].value - value) < 4 * taught[name].std for name, value in truth.items())
