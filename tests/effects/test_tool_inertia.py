"""What hangs on a sensor, by Newton's law for the tool alone, and by an integrator of cart and tool as two bodies."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given

from cartgrasp.contacts import ContactWrenches, grasp_map_planar
from cartgrasp.effects import ToolInertia, ViscousDrag
from cartgrasp.effects.effect import HandMotion
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.simulation.mujoco_plant import MujocoPlant
from cartgrasp.simulation.plant import ModelPlant
from cartgrasp.simulation.sensors import SensorNoise, Sensors
from estimation import CartFilter, FilterNoise, Prior, RegressorEstimator
from estimation.whole_log.identification import identify
from estimation.whole_log.replay import replay
from tests.core.drawn import numbers, vectors

from .free_body import STEP, G, driven, pushes, recorded, turned

CART, TOOL = (24.0, 0.3, 0.05, 2.0, 3.0, 1.0), (2.0, 0.05, 0.03, -0.04)
EFFECT = ToolInertia(*TOOL)
CONTACT = np.array([-0.25, 0.1, 1.0])
GUESS = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(2.0, 1.0),))
KNOWN = Prior(known=frozenset({"tool_inertia"}))
QUIET = SensorNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@cache
def log_of(noise, duration=18.0):
    time = STEP * np.arange(round(duration / STEP))
    contacts, given = np.tile(CONTACT, (len(time), 1)), pushes(time)
    states, _ = driven(given, CART, TOOL, contacts)
    return recorded(states, contacts, given, noise)


LOUD = (0.0004, 0.005, 3.0, 0.1)


@given(start=vectors(3, -2.0, 2.0), rates=vectors(3, -2.0, 2.0), place=vectors(3, -1.0, 1.0), yaw=numbers(-3.0, 3.0))
def test_it_bears_its_weight_and_what_accelerates_it(start, rates, place, yaw):
    """The second difference of the mass's place in {s}, over an arc of steady rates."""
    mass, *at = TOOL
    in_b = place[:2] + turned(yaw) @ at[:2]
    u, w, r = start

    def where(t):
        """To third order in t; the heading begins at 0."""
        theta, velocity = r * t + rates[2] * t * t / 2, np.array([u, w])
        first = velocity * t + (rates[:2] + r * np.array([-w, u])) * t * t / 2
        return first + turned(theta) @ in_b

    h = 1e-4
    in_s = (where(h) - 2 * where(0.0) + where(-h)) / h**2
    force = mass * np.append(turned(-yaw) @ in_s, G)
    hand = HandMotion.of(start, rates, place, yaw)
    told = EFFECT.recorded(np.zeros(6), EFFECT.values, hand)
    np.testing.assert_allclose(told, np.concatenate([force, np.cross(at, force)]), atol=1e-5)


def test_at_rest_it_only_weighs():
    weight = 2.0 * G
    expected = [0.0, 0.0, weight, 0.03 * weight, -0.05 * weight, 0.0]
    np.testing.assert_allclose(EFFECT.recorded(np.zeros(6), EFFECT.values), expected)


def test_sensors_of_a_simulated_cart_record_what_moves_both():
    """The cart moves as if two bodies were pushed by what is recorded."""
    truth = CartModel(Inertia(24.0, (0.3, 0.05), 2.0), effects=(ViscousDrag(3.0, 1.0), EFFECT))
    plant, sensors = ModelPlant(truth), Sensors(truth, QUIET)
    given, told, poses = pushes(STEP * np.arange(300)), [], []
    for fx, fy, tau in given:
        push = ContactWrenches({"hand": np.array([fx, fy, 0.0, 0.0, 0.0, tau])}, {"hand": CONTACT})
        poses.append(sensors.motion(plant.time, plant.motion).pose)
        told.append(sensors.wrenches(plant.time, push, plant.acceleration(push)).wrenches["hand"][[0, 1, 5]])
        plant.step(push, STEP)
    states, _ = driven(told, CART, TOOL, np.tile(CONTACT, (len(told), 1)))
    np.testing.assert_allclose(states[:, :3], poses, atol=5e-4)
    assert np.abs(np.subtract(told, given)[:, 0]).max() > 1.5


def test_mujoco_says_how_it_accelerates():
    """By differences of its speeds."""
    plant = MujocoPlant(CartModel(Inertia(24.0, (0.3, 0.0), 2.0)), velocity=[0.4, 0.2])
    push = ContactWrenches({"hand": np.array([20.0, 0.0, 0.0, 0.0, 0.0, 2.0])}, {"hand": np.array([-0.2, 0.0, 0.1])})
    for _ in range(20):
        plant.step(push, 0.01)
    before = plant.motion.velocity
    acceleration = plant.acceleration(push)
    plant.step(push, 0.005)
    np.testing.assert_allclose((plant.motion.velocity - before) / 0.005, acceleration, atol=0.03)


@pytest.mark.long
def test_the_filter_knows_the_cart_from_the_tool():
    log, level = log_of(LOUD, 12.0), replace(KNOWN, slope=0.0)
    given = FilterNoise(*(LOUD[0],) * 2, *(LOUD[1],) * 2, *LOUD[2:])
    with_it = replay(log, CartFilter(GUESS.with_effect(EFFECT), ["hand"], noise=given, prior=level)).last
    without = replay(log, CartFilter(GUESS, ["hand"], noise=given, prior=Prior(slope=0.0))).last
    for name, value in {"mass": 24.0, "com_x": 0.3, "com_y": 0.05}.items():
        found = with_it.parameters[name]
        assert abs(found.value - value) < 3 * found.std
    assert without.parameters["mass"].value - with_it.parameters["mass"].value == pytest.approx(2.0, abs=0.1)
    assert with_it.parameters["mass"].std < 0.2
    assert with_it.health == without.health == "ok"
    other = replay(log, RegressorEstimator(GUESS.with_effect(EFFECT), ["hand"], noise=given, prior=KNOWN)).last
    assert abs(other.parameters["mass"].value - 24.0) < 3 * other.parameters["mass"].std


@pytest.mark.long
def test_identify_knows_the_cart_from_the_tool():
    log = log_of(LOUD)
    with_it = identify([log], GUESS.with_effect(EFFECT), prior=KNOWN).parameters
    without = identify([log], GUESS).parameters["mass"]
    for name, value in {"mass": 24.0, "com_x": 0.3, "com_y": 0.05, "inertia": 2.0}.items():
        assert abs(with_it[name].value - value) < 3 * with_it[name].std
    assert without.value - with_it["mass"].value == pytest.approx(2.0, abs=0.1)


@pytest.mark.long
def test_one_place_does_not_tell_the_tool_from_the_cart_and_that_is_said():
    found = identify([log_of(LOUD)], GUESS.with_effect(ToolInertia(1.0))).parameters
    assert not found["tool_inertia.mass"].identifiable
    assert abs(found["mass"].value - 24.0) < 3 * found["mass"].std


@pytest.mark.long
def test_a_known_cart_tells_the_tool():
    body = replace(GUESS, inertia=Inertia(24.0, (0.3, 0.05), 2.0), effects=(ViscousDrag(3.0, 1.0), ToolInertia(0.5)))
    prior = Prior(known=frozenset({"mass", "com_x", "com_y", "inertia"}))
    found = identify([log_of(LOUD)], body, prior=prior).parameters["tool_inertia.mass"]
    assert found.identifiable
    assert abs(found.value - 2.0) < 3 * found.std


def test_the_correction_takes_the_tools_inertia_off_the_planar_wrench():
    """Of one moment, by Lagrange's equations of the tool alone."""
    given, contacts = pushes(STEP * np.arange(150)), np.tile(CONTACT, (150, 1))
    states, accelerations = driven(given, CART, TOOL, contacts)
    m, dx, dy, inertia, linear, angular = CART
    (u, r), (du, dr) = states[-1, 3:], accelerations[-1]
    on_cart = [
        m * (du - dy * dr - dx * r * r) + linear * u,
        (inertia + m * (dx**2 + dy**2)) * dr - m * dy * du + m * dx * u * r + angular * r,
    ]
    model = GUESS.with_effect(EFFECT)
    fx, fy, tau = given[-1]
    hand = model.hand_motion(np.array([u, r]), np.array([du, dr]), CONTACT)
    true, _ = model.corrected_wrench("hand", np.array([fx, fy, 0.0, 0.0, 0.0, tau]), hand=hand)
    np.testing.assert_allclose(model.basis_b.T @ grasp_map_planar(CONTACT) @ true, on_cart, atol=1e-9)
