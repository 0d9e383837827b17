"""Loads that come or go in the first second of a drive, while the mass is hardly known."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp import CartModel, ContactWrenches, Inertia
from cartgrasp.effects import RollingResistance, ViscousDrag
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from estimation import CartFilter, DisturbedFilter, FilterNoise

HOLDS = {"left": np.array([-0.25, 0.2, 1.0]), "right": np.array([-0.25, -0.2, 1.0])}
EFFECTS = ViscousDrag(2.0, 0.4), RollingResistance(0.012)
BEFORE, AFTER = 40.0, {"off": 24.0, "on": 64.0}


def cart(mass):
    return CartModel(Inertia(mass, (0.3, 0.03), 0.09 * mass), effects=EFFECTS)


def driven(kind, at, mass, seed):
    """Times, health, and how many deviations the mass is off where it is told as identifiable (else 0)."""
    made = kind(cart(32.0), list(HOLDS), noise=FilterNoise(force=1.0, moment=0.05))
    sensors = Sensors(cart(BEFORE), SensorNoise(force=1.0, moment=0.05), seed)
    plant, told = ModelPlant(cart(BEFORE)), []
    for k in range(1000):
        time = 0.01 * k
        if plant.cart.inertia.mass == BEFORE and time >= at:
            plant = ModelPlant(cart(mass), plant.motion.pose_sb, plant.motion.velocity)
        force = 0.4 * mass * np.cos(1.1 * time) + 6.0
        turn = 3.0 * np.sin(1.7 * time)
        given = ContactWrenches(
            {"left": [force / 2, 0, 0, 0, 0, turn / 2], "right": [force / 2, 0, 0, 0, 0, turn / 2]}, HOLDS
        )
        made.update(sensors.motion(time, plant.motion))
        estimate = made.update(sensors.wrenches(time, given))
        plant.step(given, 0.01)
        found, true = estimate.parameters["mass"], plant.cart.inertia.mass
        is_sure = found.identifiable and estimate.health == "ok"
        told.append((time, estimate.health, (found.value - true) / found.std if is_sure else 0.0))
    return told, estimate


@pytest.mark.some(4)
@pytest.mark.parametrize("kind", [CartFilter, DisturbedFilter])
@pytest.mark.parametrize("at", [0.5, 0.7, 1.0])
@pytest.mark.parametrize("load", AFTER)
def test_nothing_is_sure_and_wrong_a_second_later(kind, at, load):
    """But for 0.7 s of one of them, in which louder noise is as likely. Before, half of them told a mass that was
    4 to 10 deviations off for up to 3 s, with health ok."""
    told, last = driven(kind, at, AFTER[load], 4)
    late = [off for time, _, off in told if time > at + 1.0]
    assert np.mean(np.abs(late) > 4.0) < 0.09
    mass = last.parameters["mass"]
    assert abs(mass.value - AFTER[load]) < max(3.0 * mass.std, 0.03 * AFTER[load])


def test_the_first_wrenches_are_not_missing():
    """They reach what learns 0.2 s late, and are there."""
    told, _ = driven(DisturbedFilter, 9.0, AFTER["on"], 2)
    assert {health for time, health, _ in told if 0.0 < time < 2.0} <= {"ok", "outliers"}
