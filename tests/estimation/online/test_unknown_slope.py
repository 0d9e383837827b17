"""Floors whose slope nobody told of: what is learned on them, and that nobody is told a parameter that isn't his."""

from functools import cache

import numpy as np
import pytest

from cartgrasp.arms import Arm
from cartgrasp.contacts import ContactWrenches
from cartgrasp.effects import FloorSlope, RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from estimation import CartFilter, DisturbedFilter, FilterNoise, Prior, RegressorEstimator
from planning import Controller, PathReference, chain, pause
from planning.references import speed_change, turn

TRUTH = CartModel(Inertia(24.0, (0.3, 0.05), 2.2), effects=(ViscousDrag(3.0, 1.2), RollingResistance(0.01)))
GUESS = TRUTH.with_inertia(Inertia(20.0, (0.25, 0.0), 2.0))
PATH = PathReference(chain(speed_change(0.6), turn(0.8, 0.3), pause(3.0), turn(-0.8, 0.3), speed_change(-0.6)))
NOISE = FilterNoise(force=1.0, moment=0.05)
HOLDS = {"left": (-0.25, 0.2, 1.0), "right": (-0.25, -0.2, 1.0)}
BOTH = [CartFilter, DisturbedFilter]


@cache
def steps(kind, grades, known=()):
    """Each step of a controller on a floor with these grades, and the cart's motion after it."""
    hands = [Arm(name, [at], force_limit=(60.0,) * 3, moment_limit=(8.0,) * 3) for name, at in HOLDS.items()]
    learner = kind(GUESS, list(HOLDS), noise=NOISE, prior=Prior(known=frozenset(known)))
    controller = Controller(GUESS, hands, PATH, estimator=learner, regrasp=None)
    plant = ModelPlant(TRUTH.with_effect(FloorSlope(*grades)))
    sensors, told = Sensors(TRUTH, SensorNoise(force=1.0, moment=0.05), 0), []
    while plant.time < 12.0:
        step = controller.step(sensors.motion(plant.time, plant.motion))
        controller.observe(sensors.wrenches(plant.time, step.given))
        plant.step(step.given, 0.01)
        told.append((step, plant.motion))
    return told


@pytest.mark.parametrize("kind", BOTH)
@pytest.mark.parametrize("grades", [(0.02, 0.0), (-0.02, 0.01), pytest.param((0.0, -0.02), marks=pytest.mark.prove)])
def test_parameters_are_those_of_the_cart(kind, grades):
    """A filter that took the floor for level told the mass 7 deviations off and the CoM 15, with health `ok`."""
    told = steps(kind, grades)
    true = {"mass": 24.0, "com_x": 0.3, "com_y": 0.05, "inertia": 2.2, "rolling_resistance.coefficient": 0.01}
    for step, _ in told[100::50]:
        assert step.health == "ok"
        for name, value in true.items():
            found = step.estimate.parameters[name]
            assert abs(found.value - value) < 4.0 * found.std, name
    assert told[-1][0].estimate.parameters["mass"].std < 1.0


@pytest.mark.parametrize("kind", BOTH)
def test_what_is_learned_of_the_slope_is_fed_forward(kind):
    """2.2 cm off with a `CartFilter`, while feedback alone answered it."""
    off = [np.linalg.norm((motion.pose_sb - step.reference.pose_sb)[:2]) for step, motion in steps(kind, (0.02, 0.0))]
    assert max(off) < 0.015
    assert off[-1] < 0.005


def test_the_slope_is_learned_where_the_cart_turns():
    """By the cart's way along it, since nobody feels what fixed wheels hold."""
    floor = steps(CartFilter, (0.015, -0.01), ("rolling_resistance",))[-1][0].estimate.floor
    assert floor[:2] == pytest.approx([0.015, -0.01], abs=0.003)


@cache
def pushed(kind, has_slope=False, is_level=False):
    """The estimator after some pushes to and fro."""
    cart, prior = GUESS.with_effect(FloorSlope()) if has_slope else GUESS, Prior(slope=0.0) if is_level else None
    made, plant = kind(cart, list(HOLDS), noise=NOISE, prior=prior), ModelPlant(TRUTH)
    sensors = Sensors(TRUTH, SensorNoise(force=1.0, moment=0.05), 1)
    while plant.time < 3.0:
        force = 12.0 * np.sin(2.0 * plant.time) / 2
        given = ContactWrenches({name: [force, 0.0, 0.0, 0.0, 0.0, 0.3] for name in HOLDS}, HOLDS)
        made.update(sensors.motion(plant.time, plant.motion))
        estimate = made.update(sensors.wrenches(plant.time, given))
        plant.step(given, 0.01)
    return made, estimate


@pytest.mark.parametrize("kind", [*BOTH, RegressorEstimator])
def test_nobody_is_told_more_parameters_than_the_cart_has(kind):
    made, estimate = pushed(kind)
    p = len(GUESS.parameters)
    assert list(estimate.parameters) == list(pushed(kind, is_level=True)[1].parameters)
    assert estimate.model_parameters.shape == (p,)
    assert estimate.covariance.shape == (p, p)
    assert estimate.cart().effects == GUESS.with_parameters(estimate.model_parameters).effects
    assert estimate.floor.shape == (4,)
    slope = estimate.cart_on_floor().effects[-1]
    assert slope.values == pytest.approx(estimate.floor)
    if kind is RegressorEstimator:
        assert made.belief.mean.shape == (len(made.prior.free(GUESS)),)


@pytest.mark.parametrize("kind", [*BOTH, RegressorEstimator])
def test_each_begins_with_the_numbers_of_its_own_cart(kind):
    """Carts that differ in numbers alone share what does not depend on these."""
    for mass in (12.0, 30.0):
        learner = kind(GUESS.with_inertia(Inertia(mass, (0.2, 0.01), 1.5)), list(HOLDS), noise=NOISE)
        told = learner.update(Measurement(0.0, pose=[0.0, 0.0, 0.0], velocity=[0.0, 0.0, 0.0]))
        assert told.parameters["mass"].value == pytest.approx(mass)
        assert told.parameters["com_x"].value == pytest.approx(0.2)
        assert told.cart_on_floor().inertia.mass == pytest.approx(mass)


@pytest.mark.parametrize("kind", [*BOTH, RegressorEstimator])
def test_none_is_looked_for_where_there_is_one_or_none(kind):
    """A slope of the cart's own is reported as any effect; a floor that is known to be level has none."""
    assert pushed(kind, has_slope=True)[1].floor is None
    assert "floor_slope.grade_x" in pushed(kind, has_slope=True)[1].parameters
    level = pushed(kind, is_level=True)[1]
    assert level.floor is None
    assert level.cart_on_floor() == level.cart()
