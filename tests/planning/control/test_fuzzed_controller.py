"""Faults of the senses in the loop: whatever is sensed, wrenches are finite and within the arms' limits, and no hand
jumps."""

from __future__ import annotations

import math

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.effects import ViscousDrag
from cartgrasp.errors import UsageError
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from estimation import CartFilter, DisturbedFilter, FilterNoise
from planning import Caution, Choosing, Controller, PathReference, RegraspTimes, chain, pause
from planning.contact_sources.strategies import STRATEGIES
from planning.references import speed_change, turn

DRAG = ViscousDrag(3.0, 1.2)
TRUTH = cg.CartModel(cg.Inertia(24.0, (0.3, 0.05), 2.2), effects=(DRAG,))
GUESS = cg.CartModel(cg.Inertia(16.0, (0.25, 0.0), 2.0), effects=(DRAG,))
PATH = PathReference(chain(speed_change(0.5), turn(0.8, 0.4), pause(1.0), turn(-0.8, 0.4), speed_change(-0.5)))
TIMES = RegraspTimes(speed=1.0, unload=0.1, take_hold=0.05, load=0.1)
FORCE, MOMENT = 60.0, 8.0
ODD = (np.nan, np.inf, -np.inf, 1e300, -1e12, 0.0, 1e-300)


def arms():
    sides = {"left": 1, "right": -1}
    places = ((-0.25, 0.2, 1.0), (0.1, 0.3, 0.9), (-0.25, 0.35, 1.0))
    limits = {"force_limit": (FORCE,) * 3, "moment_limit": (MOMENT,) * 3}
    return [cg.Arm(name, [(x, s * y, z) for x, y, z in places], **limits) for name, s in sides.items()]


def spoiled(measured, random):
    """A fault for some ticks in a hundred: a part is missing, odd, or jumps; time stands still or goes back."""
    pose, velocity, time, kind = measured.pose, measured.velocity, measured.time, random.integers(0, 60)
    if kind == 0:
        pose = None
    elif kind == 1:
        velocity = np.full(3, random.choice(ODD))
    elif kind == 2:
        pose = pose.copy()
        pose[random.integers(0, 3)] = random.choice(ODD)
    elif kind == 3:
        pose = pose + random.normal(0.0, 1.0, 3)
    elif kind == 4:
        time = time - random.choice([0.0, 0.005, 0.2, 3.0])
    elif kind == 5:
        return cg.Measurement(time)
    return cg.Measurement(time, pose, velocity)


@pytest.mark.long
@pytest.mark.some(5)
@pytest.mark.filterwarnings("ignore:(invalid value|overflow) encountered:RuntimeWarning")  # of the EKF, by odd numbers
@pytest.mark.parametrize("way", STRATEGIES)
@pytest.mark.parametrize("seed", range(3))
def test_whatever_is_sensed(way, seed):
    random = np.random.default_rng([seed, STRATEGIES.index(way)])
    noise = FilterNoise(force=1.0, moment=0.05) if seed < 2 else FilterNoise(force=0.0, moment=0.0)  # either filter
    kind = DisturbedFilter if seed == 1 else CartFilter
    controller = Controller(
        GUESS,
        arms(),
        PATH,
        contacts=way,
        choosing=Choosing(every=0.7, ahead=2.0),
        regrasp=TIMES,
        caution=Caution() if seed else None,
        estimator=kind(GUESS, ["left", "right"], noise=noise),
    )
    plant, sensors = ModelPlant(TRUTH), Sensors(TRUTH, SensorNoise(force=1.0, moment=0.05), seed)
    before, last = None, 0.0
    for _ in range(500):
        measured = spoiled(sensors.motion(plant.time, plant.motion), random)
        step = controller.step(measured)
        for name, wrench in step.wrenches.items():
            assert np.isfinite(wrench).all()
            assert (np.abs(wrench) <= np.repeat([FORCE, MOMENT], 3) + 1e-6).all()
            if before is not None:
                moved = math.dist(before.contacts[name], step.contacts[name])
                assert moved <= TIMES.speed * max(0.0, measured.time - last) * (1 + 1e-9) + 1e-12
                if moved > 0:
                    assert (wrench == 0).all()
        before, last = step, measured.time
        felt = sensors.wrenches(plant.time, step.given)
        if random.integers(0, 60) == 0:
            odd = {name: np.full(6, random.choice(ODD)) for name in ("left", "right")[: random.integers(0, 3)]}
            felt = cg.Measurement(felt.time, wrenches={**felt.wrenches, **odd}, contacts=felt.contacts)
        controller.observe(felt)
        plant.step(step.given, 0.01)


def test_a_time_that_is_none_is_refused():
    """In one sentence; the controller goes on after it."""
    controller = Controller(GUESS, arms(), PATH)
    controller.step(cg.Measurement(0.0, np.zeros(3), np.zeros(3)))
    with pytest.raises(UsageError, match="time"):
        controller.step(cg.Measurement(math.nan, np.zeros(3), np.zeros(3)))
    assert controller.step(cg.Measurement(0.01, np.zeros(3), np.zeros(3))).plan.status == "optimal"
