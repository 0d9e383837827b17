"""Sources of poses that move or turn, with the world's velocity as it is: a cart is driven neither there nor away."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.effects import FloorSlope, ViscousDrag
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from cartgrasp.studies.shopping_cart import WHEELS
from estimation import CartFilter, DisturbedFilter, FilterNoise
from estimation.sensor_check.suspicion import Suspicion
from planning import Caution, Controller, PathReference, chain, pause
from planning.control.protective_stop import DRIVING, Stage
from planning.references import speed_change, turn

TRUTH = cg.CartModel(cg.Inertia(24.0, (0.3, 0.05), 2.2), effects=(ViscousDrag(3.0, 1.2),), wheels=WHEELS)
GUESS = TRUTH.with_inertia(cg.Inertia(20.0, (0.25, 0.0), 2.0))
PATH = PathReference(chain(speed_change(0.6), turn(0.8, 0.3), pause(3.0), turn(-0.8, 0.3), speed_change(-0.6)))
NOISE = SensorNoise(force=1.0, moment=0.05)
FILTERS = {"CartFilter": CartFilter, "DisturbedFilter": DisturbedFilter}
MOVED = {
    "moved": lambda pose: pose - np.array([3.0, 4.0, 0.0]),
    "turned about": lambda pose: pose + np.array([0.0, 0.0, np.pi]),
    "turned": lambda pose: pose + np.array([0.0, 0.0, 0.5]),
    "another frame": lambda pose: np.array([1.0 - pose[1], pose[0], pose[2] + np.pi / 2.0]),
    "in degrees": lambda pose: pose * [1.0, 1.0, 180.0 / np.pi],
}


def driven(kind, until, duration, estimator, **options):
    """Steps with the true motion, of poses that are wrong from 2 s on."""
    hands = [
        cg.Arm(name, [(-0.25, y, 1.0)], force_limit=(60.0,) * 3, moment_limit=(8.0,) * 3)
        for name, y in (("left", 0.2), ("right", -0.2))
    ]
    learner = estimator(GUESS, ["left", "right"], noise=FilterNoise(force=1.0, moment=0.05))
    controller = Controller(GUESS, hands, PATH, estimator=learner, regrasp=None, **options)
    plant, sensors, told = ModelPlant(TRUTH), Sensors(TRUTH, NOISE, 0), []
    while plant.time < duration:
        seen = sensors.motion(plant.time, plant.motion)
        if 2.0 <= plant.time < until:
            seen = replace(seen, pose=MOVED[kind](np.asarray(seen.pose)))
        step = controller.step(seen)
        controller.observe(sensors.wrenches(plant.time, step.given))
        plant.step(step.given, 0.01)
        told.append((step, plant.motion))
    return told


@pytest.mark.long
@pytest.mark.some(3)
@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("kind", MOVED)
def test_for_a_moment_the_cart_stays_on_its_path(kind, name):
    """Velocities tell the way meanwhile. Before, half a turn for a second sped the cart up to 31 m/s."""
    told = driven(kind, 2.8, 6.0, FILTERS[name])
    off = [float(np.linalg.norm((motion.pose_sb - step.reference.pose_sb)[:2])) for step, motion in told]
    assert max(off[:480]) < 0.3
    assert off[-1] < 0.05
    assert max(abs(motion.velocity[0]) for _, motion in told) < 0.66


@pytest.mark.long
@pytest.mark.some(3)
@pytest.mark.parametrize("name", FILTERS)
@pytest.mark.parametrize("kind", MOVED)
def test_for_good_the_cart_is_not_driven_faster(kind, name):
    told = driven(kind, 100.0, 12.0, FILTERS[name])
    speeds = [abs(motion.velocity[0]) for _, motion in told]
    assert max(speeds) < 0.9
    if kind == "moved":
        assert speeds[-1] < 0.02
        assert "stops: the cart is" in told[-1][0].words
    if kind in ("turned about", "in degrees"):
        step = told[-1][0]
        assert "gives nothing: " in step.words
        assert not any(wrench.any() for wrench in step.wrenches.values())


def test_without_caution_it_is_driven_there_no_faster_than_errors_reach():
    told = driven("moved", 100.0, 7.0, CartFilter, caution=None)
    assert 0.7 < max(abs(motion.velocity[0]) for _, motion in told) < 0.6 + 1.5 * 0.5 + 0.1


@pytest.mark.parametrize("slope", [0.0, 0.03, -0.05])
def test_a_stopped_cart_is_held_on_a_slope(slope):
    """That nobody knows of. Let go by mistake it rolled 34 m; with nothing but braking it crept on for ever."""
    truth = replace(TRUTH, effects=(*TRUTH.effects, FloorSlope(slope, 0.0)))
    hands = [cg.Arm("hand", [(-0.25, 0.0, 1.0)])]
    controller = Controller(GUESS, hands, PATH, regrasp=None)
    plant, sensors = ModelPlant(truth, pose_sb=(-1.4, 0.0, 0.0)), Sensors(truth, NOISE, 0)
    while plant.time < 8.0:
        step = controller.step(sensors.motion(plant.time, plant.motion))
        assert step.slowed.startswith("stops: the cart is 1.") or plant.time < 0.02
        controller.observe(sensors.wrenches(plant.time, step.given))
        plant.step(step.given, 0.01)
    assert abs(plant.motion.pose_sb[0] + 1.4) < 0.35
    assert abs(plant.motion.velocity[0]) < 0.01


def estimate(x, heading, u):
    """Of a cart that is there, in {s}, and rolls so fast."""
    learner = CartFilter(TRUTH)
    told = learner.update(cg.Measurement(0.0, pose=[0, 0, 0]))
    return told._replace(motion=cg.Motion(np.array([x, 0.0, heading]), np.array([u, 0.0])))


def stopped(speeds, interval=0.01):
    """Stops (n,) of a cart that is 1.2 m off its path, by its speed every 10 ms."""
    stop, found = DRIVING, []
    for k, u in enumerate(speeds):
        stop = stop.after(interval * k, TRUTH, PATH.at(0.0), estimate(1.2, 0.0, u), 1.0)
        found.append(stop)
    return found


def test_it_begins_and_ends_with_the_error():
    for x, heading, why in ((0.9, 0.0, ""), (1.1, 0.0, "1.1 m off its path"), (0.0, 2.0, "heads 115° off its path")):
        stop = DRIVING.after(0.0, TRUTH, PATH.at(0.0), estimate(x, heading, 0.5), 1.0)
        assert stop.why == (f"stops: the cart {'is ' if x else ''}{why}" if why else "")
        assert stop.after(0.01, TRUTH, PATH.at(0.0), estimate(0.9, 0.0, 0.5), 1.0) is DRIVING


def test_a_stop_is_monitored():
    """A quick cart that gets quicker is let go, for 0.5 s, then 1 s, and so on; and braked gently between."""
    stops = stopped(0.6 + 0.05 * np.arange(400) / 100.0)
    changes = [k for k in range(1, 400) if stops[k].stage is not stops[k - 1].stage]
    np.testing.assert_allclose(np.diff([0, *changes[:4]]), [20, 50, 20, 100], atol=1)
    assert [stops[k].share for k in (0, changes[0] - 1, changes[1], changes[2] - 1)] == [1.0, 1.0, 0.25, 0.25]
    assert stops[changes[0]].why == "gives nothing: the cart is 1.2 m off its path"
    assert {stop.stage for stop in stopped(0.6 * np.exp(-np.arange(400) / 50.0))} == {Stage.BRAKES}
    assert {stop.stage for stop in stopped(0.49 * (1.0 - np.exp(-np.arange(400) / 50.0)))} == {Stage.BRAKES}, "a slope"


def test_what_was_pushed_is_stopped_after_all():
    """Somebody pushes on for half a second: it is let go, and braked, usually hard once that is seen to brake."""
    pushed = [0.6 + 2.0 * min(k, 50) / 100.0 for k in range(70)]
    stops = stopped([*pushed, *(pushed[-1] * np.exp(-np.arange(100) / 100.0))])
    assert stops[25].stage is Stage.LETS_GO
    assert [stops[75].stage, stops[75].share] == [Stage.BRAKES, 0.25]
    assert [stops[-1].stage, stops[-1].share] == [Stage.BRAKES, 1.0]


def test_what_surely_is_not_the_motion_is_not_braked_by():
    caution, told = Caution().astray, estimate(0.0, 0.0, 0.5)
    kinds = ("unit", "heading", 0.95), ("unit", "heading", 0.6), ("sign", "wrench", 0.99), ("noise", "velocity", 1.0)
    stages = [
        DRIVING.after(0.0, TRUTH, PATH.at(0.0), told._replace(suspicions=(Suspicion(*one, 1.0, "so"),)), caution).stage
        for one in kinds
    ]
    assert stages == [Stage.LETS_GO, Stage.DRIVES, Stage.DRIVES, Stage.DRIVES]
