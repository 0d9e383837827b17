"""Our plant against an adaptive stiff integrator, and sensors against their statistics."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from cartgrasp.contacts import ContactWrenches
from cartgrasp.effects import CasterRealignment, ForceBias, RollingResistance, ViscousDrag
from cartgrasp.errors import CartgraspError, PlantError, UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Motion
from cartgrasp.simulation.plant import ModelPlant
from cartgrasp.simulation.sensors import SensorNoise, Sensors
from cartgrasp.studies.shopping_cart import WHEELS, loaded_cart

CART = CartModel(Inertia(24.0, (0.3, 0.05), 2.0), effects=(ViscousDrag(linear=3.0, angular=1.0),), wheels=WHEELS)
PUSH = ContactWrenches(
    {"a": np.array([20.0, 1.0, 0, 0, 0, 1.0]), "b": np.array([5.0, 0, 2.0, 0, 0, 0])},
    {"a": np.array([-0.25, 0.2, 1.0]), "b": np.array([-0.25, -0.2, 1.0])},
)


@pytest.mark.parametrize(
    ("cart", "tolerance"),
    [(CART, 1e-9), (CART.with_effect(RollingResistance(coefficient=0.02)), 2e-5), (loaded_cart(), 5e-4)],
    ids=["viscous", "rolling", "casters"],
)
def test_against_a_stiff_adaptive_integrator(cart, tolerance):
    plant = ModelPlant(cart, caster_headings=None if not cart.memory_names else [1.0, -2.0])
    state = plant.state
    for _ in range(200):
        plant.step(PUSH, 0.01)
    wrench = PUSH.wrench_b
    solved = solve_ivp(lambda t, y: cart.state_rate(y, wrench), (0, 2.0), state, "LSODA", rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(plant.state, solved.y[:, -1], atol=tolerance)
    assert plant.time == pytest.approx(2.0)


def test_a_finer_step_changes_little():
    coarse, fine = ModelPlant(CART, timestep=0.01), ModelPlant(CART, timestep=0.001)
    for _ in range(100):
        coarse.step(PUSH, 0.01)
        fine.step(PUSH, 0.01)
    np.testing.assert_allclose(coarse.state, fine.state, atol=1e-9)


def test_a_state_that_is_not_finite_is_an_error():
    plant = ModelPlant(CART)
    wild = ContactWrenches({"a": np.full(6, 1e200)}, {"a": np.zeros(3)})
    with np.errstate(all="ignore"), pytest.raises(PlantError, match="not finite"):
        plant.step(wild, 5.0)


def test_a_push_that_is_refused_moves_nothing():
    plant = ModelPlant(CART)
    before = plant.state
    for bad, duration in ((np.nan, 0.1), (1e300, 0.1), (1.0, np.inf)):
        push = ContactWrenches({"a": np.full(6, bad)}, {"a": np.zeros(3)})
        with np.errstate(all="ignore"), pytest.raises(CartgraspError, match=r"finite|duration"):
            plant.step(push, duration)
    assert plant.time == 0.0
    np.testing.assert_array_equal(plant.state, before)


@pytest.mark.parametrize("wrong", [np.nan, (0.1, 0.2, 0.3), "left"])
def test_caster_headings_that_are_none(wrong):
    cart = CART.with_effect(CasterRealignment(0.3))
    assert set(ModelPlant(cart, caster_headings=0.4).caster_headings) == {0.4}
    with pytest.raises(UsageError, match="caster_headings"):
        ModelPlant(cart, caster_headings=wrong)


def test_sensors_have_the_noise_they_state_and_the_bias_they_are_given():
    cart = CART.with_effect(ForceBias(fx=2.0, tz=-0.3, label="a"))
    noise = SensorNoise(0.01, 0.02, 0.03, 0.04, 1.5, 0.2)
    sensors = Sensors(cart, noise, seed=3)
    motion = Motion(np.array([1.0, 2.0, 0.5]), np.array([0.6, 0.2]))
    seen = [sensors.motion(0.01 * k, motion) for k in range(4000)]
    felt = [sensors.wrenches(0.01 * k, PUSH).wrenches for k in range(4000)]
    pose = np.array([m.pose for m in seen]) - motion.pose_sb
    velocity = np.array([m.velocity for m in seen])
    np.testing.assert_allclose(pose.std(axis=0), [0.01, 0.01, 0.02], rtol=0.05)
    expected = [0.6 * np.cos(0.5), 0.6 * np.sin(0.5), 0.2]
    np.testing.assert_allclose(velocity.mean(axis=0), expected, atol=0.003)
    np.testing.assert_allclose(velocity.std(axis=0), [0.03, 0.03, 0.04], rtol=0.05)
    left = np.array([f["a"] for f in felt]) - PUSH.wrenches["a"]
    right = np.array([f["b"] for f in felt]) - PUSH.wrenches["b"]
    np.testing.assert_allclose(left.mean(axis=0), [2.0, 0, 0, 0, 0, -0.3], atol=0.1)
    np.testing.assert_allclose(right.mean(axis=0), 0.0, atol=0.1)
    np.testing.assert_allclose(left.std(axis=0), [1.5] * 3 + [0.2] * 3, rtol=0.05)


def test_samples_that_nobody_asked_for_in_time_are_not_made_up_for():
    sensors, motion = Sensors(CART, SensorNoise(pose_period=0.1)), Motion(np.zeros(3), np.zeros(2))
    times = [*np.arange(5.0, 5.3, 0.01), *np.arange(7.03, 7.3, 0.01)]
    told = [time for time in times if sensors.motion(time, motion).pose is not None]
    assert told == pytest.approx([5.0, 5.1, 5.2, 7.03, 7.1, 7.2])


def test_sample_times_and_seeds():
    noise = SensorNoise(pose_period=0.05, velocity_period=None, wrench_period=0.02)
    motion = Motion(np.zeros(3), np.zeros(2))

    def run(seed):
        sensors = Sensors(CART, noise, seed)
        return [(sensors.motion(0.01 * k, motion), sensors.wrenches(0.01 * k, PUSH)) for k in range(101)]

    first, again, other = run(1), run(1), run(2)
    assert sum(m.pose is not None for m, _ in first) == 21
    assert all(m.velocity is None for m, _ in first)
    assert sum(bool(w.wrenches) for _, w in first) == 51
    np.testing.assert_array_equal(first[50][0].pose, again[50][0].pose)
    assert not np.array_equal(first[50][0].pose, other[50][0].pose)
