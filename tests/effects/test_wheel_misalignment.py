"""Fixed wheels at an angle, against the same cart seen from a frame that is turned with them. The constrained equations
are compared in `tests/core/test_constrained_dynamics.py`."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import QuadraticDrag, RollingResistance, ViscousDrag, WheelMisalignment
from cartgrasp.errors import UsageError
from cartgrasp.floor_reaction import FloorReaction
from cartgrasp.frames import rotation_planar
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog
from cartgrasp.model import CartModel
from cartgrasp.motion import Motion
from cartgrasp.simulation.integrate import runge_kutta_4
from estimation import CartFilter, FilterNoise
from estimation.whole_log.identification import identify
from estimation.whole_log.replay import replay
from planning.references import PathReference, chain, pause, speed_change, turn
from planning.tracking import SteeringTracker
from tests.core.differences import assert_partials
from tests.core.drawn import SHOPPING_CART, inertias, numbers, poses, vectors, wrenches
from tests.core.test_constrained_dynamics import body_velocity, solve_kkt, to_world
from tests.estimation.runs import simulate

angles = numbers(-0.5, 0.5)
DRAG = ViscousDrag(3.0, 1.0)  # the same in every direction


def turned(planar, angle):
    """Components of (x, y, ...) in a frame that is turned by `angle`."""
    return np.concatenate([rotation_planar(-angle) @ planar[:2], planar[2:]])


@given(inertia=inertias(), pose=poses(), nu=vectors(2, -2, 2), wrench_b=wrenches(), angle=angles)
def test_it_is_a_cart_whose_frame_is_turned_with_its_wheels(inertia, pose, nu, wrench_b, angle):
    cart = CartModel(inertia, effects=(DRAG, WheelMisalignment(angle)))
    same = CartModel(replace(inertia, com=tuple(turned(np.array(inertia.com), angle))), effects=(DRAG,))
    rate = cart.state_rate(cart.state(pose, nu), wrench_b)
    expected = same.state_rate(same.state([*pose[:2], pose[2] + angle], nu), turned(wrench_b, angle))
    np.testing.assert_allclose(rate, expected, rtol=1e-9, atol=1e-9)
    needed = cart.required_wrench(cart.state(pose, nu), rate[3:])
    np.testing.assert_allclose(needed, cart.basis_b.T @ wrench_b, atol=1e-9)
    np.testing.assert_allclose(cart.basis_b.T @ cart.planar_wrench(needed), needed, atol=1e-12)
    np.testing.assert_allclose(turned(cart.planar_wrench(needed), angle)[1], 0.0, atol=1e-12)
    np.testing.assert_allclose(cart.rolling.free_velocity(cart.basis_b @ nu), nu, atol=1e-12)


@given(nu=vectors(2, -1, 1), wrench_b=wrenches(), angle=angles, axle=numbers(-0.6, 0.6))
def test_partials(nu, wrench_b, angle, axle):
    effects = (QuadraticDrag(2.0), RollingResistance(0.02), WheelMisalignment(angle))
    cart = CartModel(Inertia(24.0, (0.3, 0.1), 2.0), RollingConstraints(axle), effects, SHOPPING_CART)
    state = cart.state((0.3, -0.2, 0.7), nu)
    rate = cart.rate(state, wrench_b)
    assert_partials(rate.by_state, lambda s: cart.state_rate(s, wrench_b), state)
    assert_partials(rate.by_wrench, lambda w: cart.state_rate(state, w), wrench_b)
    assert_partials(rate.by_parameters, lambda p: cart.state_rate(state, wrench_b, p), cart.parameters)


@given(inertia=inertias(), pose=poses(), nu=vectors(2, -2, 2), wrench_b=wrenches(), angle=angles)
def test_the_force_across_the_wheels_is_the_multiplier(inertia, pose, nu, wrench_b, angle):
    constraints = RollingConstraints(0.2)
    cart = CartModel(inertia, constraints, (WheelMisalignment(angle),), SHOPPING_CART, com_height=0.4)
    spatial = np.array([wrench_b[0], wrench_b[1], 5.0, 1.0, -2.0, wrench_b[2]])
    lateral = FloorReaction.of(cart, Motion(pose, nu)).lateral(spatial)
    qd = to_world(pose[2], body_velocity(cart.rolling, nu))
    _, forces = solve_kkt(inertia, cart.rolling, pose[2], qd, to_world(pose[2], wrench_b))
    np.testing.assert_allclose(lateral, forces[0], rtol=1e-9, atol=1e-8)


def test_another_angle_is_another_structure():
    cart = CartModel(Inertia(24.0, (0.3, 0.1), 2.0), effects=(WheelMisalignment(0.1), DRAG))
    state, wrench_b = cart.state((0, 0, 0.3), [0.5, 0.2]), np.array([20.0, 3.0, 1.0])
    before = cart.rate(state, wrench_b)
    for angle in (0.1, -0.2):
        other = cart.with_parameters([*cart.inertia.phi, angle, 4.0, 2.0])
        fresh = CartModel(cart.inertia, effects=(WheelMisalignment(angle), ViscousDrag(4.0, 2.0)))
        np.testing.assert_allclose(other.rate(state, wrench_b).value, fresh.rate(state, wrench_b).value, rtol=1e-12)
        np.testing.assert_array_equal(other.basis_b, fresh.basis_b)
    np.testing.assert_array_equal(cart.rate(state, wrench_b).value, before.value)
    angle = cart.parameter_names.index("wheel_misalignment.angle")
    assert not before.by_parameters[:, angle].any()


def test_two_of_them_add_up_and_none_turns_nothing():
    cart = CartModel(Inertia(24.0, (0.3, 0.1), 2.0))
    twice = cart.with_effect(WheelMisalignment(0.1, label="left")).with_effect(WheelMisalignment(0.05, label="right"))
    assert twice.rolling.angle == pytest.approx(0.15)
    assert cart.with_effect(WheelMisalignment()).rolling == cart.constraints


def test_what_is_refused():
    with pytest.raises(UsageError, match=r"wheel_misalignment: the cart has no fixed wheels; add the constraint"):
        CartModel(Inertia(24.0, (0.3, 0.1), 2.0), RollingConstraints(None), (WheelMisalignment(0.1),))
    with pytest.raises(UsageError, match="wheels at an angle are the effect wheel_misalignment"):
        CartModel(Inertia(24.0, (0.3, 0.1), 2.0), RollingConstraints(0.0, angle=0.1))


@pytest.mark.long
@pytest.mark.parametrize("axle", [0.4])
def test_tracking_knows_where_it_rolls(axle):
    """The true model ends without error and grows none; one that takes the wheels for straight does."""
    cart = CartModel(Inertia(20.0, (0.3, 0.1), 2.0), RollingConstraints(axle), (DRAG, WheelMisalignment(0.1)))
    parts = [speed_change(0.5), pause(2.0), turn(0.6, 0.4), pause(4.0), speed_change(-0.5)]
    path, tracker = PathReference(chain(*parts), cart.rolling), SteeringTracker()

    def errors(believed, start=(0.0, 0.0, 0.0)):
        state, found = cart.state(start), []
        for k in range(int((path.duration - 1.0) / 0.01)):

            def rate(t, y):
                return cart.state_rate(y, tracker.wrench_b(path.at(t), Motion(y[:3], y[3:]), believed))

            state = runge_kutta_4(rate, 0.01 * k, state, 0.01)
            found.append(np.abs(path.at(0.01 * (k + 1)).pose_sb - state[:3]).max())
        return found

    assert errors(cart, (-0.1, 0.1, 0.1))[-1] < 2e-3
    own, unaware = max(errors(cart)), max(errors(cart.without_effect("wheel_misalignment")))
    assert own < 2e-4
    assert unaware > 10 * own


@pytest.mark.long
def test_fits_on_a_cart_with_turned_wheels():
    """A log of a straight cart, written down in a frame that its wheels are turned against."""
    angle, com = 0.15, np.array([0.3, 0.05])
    log, _ = simulate((24.0, *com, 2.0, 3.0, 1.0, 0.0), seed=5, duration=12.0, noise=(0.0004, 0.005, 1.0))
    hand, back = log.arms["hand"], rotation_planar(angle)
    contact = np.column_stack([hand.contact[:, :2] @ back.T, hand.contact[:, 2]])
    both = np.kron(np.eye(2), np.block([[back, np.zeros((2, 1))], [np.zeros((1, 2)), 1.0]]))
    pose = log.pose - [0.0, 0.0, angle]
    log = replace(log, pose=pose, arms={"hand": ArmLog(contact, hand.wrench @ both.T)})

    guess = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(2.0, 1.0), WheelMisalignment(angle)))
    noise = FilterNoise(0.0004, 0.0004, 0.005, 0.005, 1.0, 0.05)
    batch = identify([log], guess, noise=noise).parameters
    online = replay(log, CartFilter(guess, ["hand"], noise=noise)).last.parameters
    truth = dict(zip(("mass", "com_x", "com_y", "inertia"), [24.0, *(back @ com), 2.0], strict=True))
    for found in (batch, online):
        assert found["mass"].value == pytest.approx(24.0, rel=0.02)
        for name, value in truth.items():
            assert abs(found[name].value - value) < 4 * found[name].std, name
