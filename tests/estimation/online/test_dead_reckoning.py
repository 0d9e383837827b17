"""Where nothing is seen of the motion, a `RegressorEstimator` goes on as the wrenches move the cart."""

from __future__ import annotations

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.effects import ViscousDrag
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from estimation import FilterNoise, RegressorEstimator
from planning import Controller, PathReference, chain, pause, speed_change, turn

CASTERS = cg.RollingConstraints(None)
PALLET = cg.CartModel(
    cg.Inertia(80.0, (0.03, -0.02), 12.0), constraints=CASTERS, effects=(ViscousDrag(linear=5.0, angular=2.0),)
)
GUESS = PALLET.with_inertia(cg.Inertia(60.0, (0.0, 0.0), 8.0))
ARMS = [cg.Arm(name, [(-0.6, y, 1.0)], force_limit=(120, 100, 60)) for name, y in (("left", 0.3), ("right", -0.3))]
PATH = PathReference(
    chain(speed_change(0.6), turn(1.2, 0.3), pause(1.0), turn(-1.2, 0.3), speed_change(-0.6)), constraints=CASTERS
)
NOISE = FilterNoise(force=0.5, moment=0.02)


def driven(blind=lambda time: False, **sampling):
    """Errors (m) over a run of a controller, and its last estimate."""
    plant = ModelPlant(PALLET)
    sensors = Sensors(PALLET, SensorNoise(force=0.5, moment=0.02, **sampling), seed=1)
    estimator = RegressorEstimator(GUESS, ["left", "right"], noise=NOISE)
    controller, off = Controller(GUESS, ARMS, PATH, estimator=estimator), []
    for _ in range(round(PATH.duration / controller.period)):
        sensed = sensors.motion(plant.time, plant.motion)
        step = controller.step(cg.Measurement(plant.time) if blind(plant.time) else sensed)
        off.append(float(np.hypot(*(step.reference.pose_sb - plant.motion.pose_sb)[:2])))
        estimate = controller.observe(sensors.wrenches(plant.time, step.given))
        plant.step(step.given, controller.period)
    return off, estimate


@pytest.mark.some(1)
@pytest.mark.parametrize("lasting", [0.3, 1.0])
def test_a_cart_stays_on_its_path_while_nothing_is_seen(lasting):
    off, estimate = driven(lambda time: 3.0 < time < 3.0 + lasting)
    assert max(off) < 0.02
    assert estimate.parameters["mass"].value == pytest.approx(80.0, rel=0.03)


def test_poses_that_come_seldom_are_enough():
    off, estimate = driven(pose_period=0.2, velocity_period=None)
    mass = estimate.parameters["mass"]
    assert max(off) < 0.04
    assert abs(mass.value - 80.0) < 3.0 * mass.std


def test_the_motion_between_two_poses_is_that_of_the_wrenches():
    """A push that begins at rest, seen by nobody for 0.4 s."""
    cart = cg.CartModel(cg.Inertia(24.0, (0.0, 0.0), 2.0))
    estimator, plant = RegressorEstimator(cart, ["hand"]), ModelPlant(cart)
    for k in range(100):
        estimator.update(cg.Measurement(0.01 * k, pose=[0, 0, 0], velocity=[0, 0, 0]))
        rest = cg.Measurement(0.01 * k, wrenches={"hand": np.zeros(6)}, contacts={"hand": [-0.25, 0.0, 1.0]})
        estimator.update(rest)
    push = cg.ContactWrenches({"hand": np.array([6.0, 0, 0, 0, 0, 0])}, {"hand": np.array([-0.25, 0.0, 1.0])})
    for k in range(100, 140):
        estimator.update(cg.Measurement(0.01 * k, wrenches=push.wrenches, contacts=push.contacts))
        plant.step(push, 0.01)
    told = estimator.update(cg.Measurement(1.4)).motion
    assert told.pose_sb == pytest.approx(plant.motion.pose_sb, abs=2e-3)
    assert told.velocity == pytest.approx(plant.motion.velocity, abs=5e-3)
