"""After a fault of the senses or of an arm the cart is at rest, or on its path again, within 2 s; drawn at random."""

from __future__ import annotations

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.effects import ViscousDrag
from cartgrasp.simulation import ModelPlant, SensorNoise, Sensors
from estimation import DisturbedFilter, FilterNoise
from planning import Caution, Controller, PathReference, chain, pause
from planning.references import speed_change, turn

TRUTH = cg.CartModel(cg.Inertia(24.0, (0.3, 0.05), 2.2), effects=(ViscousDrag(3.0, 1.2),))
GUESS = TRUTH.with_inertia(cg.Inertia(20.0, (0.25, 0.0), 2.0))
PATH = PathReference(chain(speed_change(0.4), turn(0.3, 0.3), pause(3.0), speed_change(-0.4)))
FORCE, MOMENT, NEAR, SLOW = 60.0, 8.0, 0.05, 0.02
ODD = (np.nan, np.inf, -np.inf, 1e300, -1e12)


def spoiled(kind, measured, random):
    """One kind of fault, tick after tick."""
    time, pose, velocity = measured.time, measured.pose, measured.velocity
    if kind == "no pose":
        return cg.Measurement(time, None, velocity)
    if kind == "nothing":
        return cg.Measurement(time)
    if kind == "odd":
        return cg.Measurement(time, np.full(3, random.choice(ODD)), np.full(3, random.choice(ODD)))
    if kind == "jumps":
        return cg.Measurement(time, pose + random.normal(0.0, 1.0, 3) * (random.random() < 0.3), velocity)
    return cg.Measurement(time - 0.2 * (kind == "late"), pose, velocity)


KINDS = ("no pose", "nothing", "odd", "jumps", "late", "no wrench", "lost arm")


def run(seed):
    random = np.random.default_rng([seed, 33])
    kind, begin, lasting = random.choice(KINDS), random.uniform(0.5, 1.5), random.uniform(0.05, 0.8)
    arms = [
        cg.Arm(name, [(-0.25, y, 1.0)], force_limit=(FORCE,) * 3, moment_limit=(MOMENT,) * 3)
        for name, y in (("left", 0.2), ("right", -0.2))
    ]
    learner = DisturbedFilter(GUESS, ["left", "right"], noise=FilterNoise(force=1.0, moment=0.05))
    controller = Controller(GUESS, arms, PATH, estimator=learner, regrasp=None, caution=Caution())
    plant, sensors = ModelPlant(TRUTH), Sensors(TRUTH, SensorNoise(force=1.0, moment=0.05), seed)
    off = []
    for k in range(round((begin + lasting + 2.0) / 0.01)):
        faulty = begin <= 0.01 * k < begin + lasting
        measured = sensors.motion(plant.time, plant.motion)
        step = controller.step(spoiled(kind, measured, random) if faulty else measured)
        given = step.given
        for wrench in step.wrenches.values():
            assert (np.abs(wrench) <= np.repeat([FORCE, MOMENT], 3) + 1e-6).all(), (seed, kind)
        felt = sensors.wrenches(plant.time, given)
        if faulty and kind == "lost arm":
            given = cg.ContactWrenches({**given.wrenches, "left": np.zeros(6)}, given.contacts)
            felt = cg.Measurement(felt.time, wrenches={**felt.wrenches, "left": np.zeros(6)}, contacts=felt.contacts)
        controller.observe(cg.Measurement(felt.time) if faulty and kind == "no wrench" else felt)
        error = plant.motion.pose_sb - step.reference.pose_sb
        off.append(float(np.hypot(error[0], error[1])))
        plant.step(given, 0.01)
    assert off[-1] < NEAR or np.abs(plant.motion.velocity).max() < SLOW, (seed, kind, off[-1])


@pytest.mark.long
@pytest.mark.some(5)
@pytest.mark.filterwarnings("ignore:(invalid value|overflow) encountered:RuntimeWarning")
@pytest.mark.parametrize("seed", range(10))
def test_a_fault_is_over_within_two_seconds(seed):
    run(seed)


@pytest.mark.prove
@pytest.mark.filterwarnings("ignore:(invalid value|overflow) encountered:RuntimeWarning")
def test_ten_thousand_faults_are():
    for seed in range(10_000):
        run(seed)
