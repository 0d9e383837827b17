"""Force and moment that rise and fall together: rows nearly leave free how mass, CoM and inertia share them. Noise of
the motion must not decide that."""

from __future__ import annotations

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.simulation import ModelPlant
from estimation import CartFilter, FilterNoise, RegressorEstimator

CART = cg.CartModel(cg.Inertia(60.0, (0.05, 0.02), 20.0))
HELD = {"hand": np.array([-1.0, 0.0, 0.9])}
NOISE = FilterNoise(position=5e-4, heading=5e-4, force=0.5, moment=0.02)


def learner_after(duration, seed, share, straight=0.0, made=CartFilter):
    """The moment is a share (m) of the force, once it was pushed straight for so many s."""
    learner = made(CART, ["hand"], noise=NOISE)
    random, plant = np.random.default_rng(seed), ModelPlant(CART)
    while plant.time < duration:
        force = 25.0 * np.sin(1.2 * plant.time) + 10.0
        given = np.array([force, 0.0, 0.0, 0.0, 0.0, share * force if plant.time >= straight else 0.0])
        felt = given + np.array([0.5, 0.5, 0.5, 0.02, 0.02, 0.02]) * random.normal(size=6)
        pose = plant.motion.pose_sb + 5e-4 * random.normal(size=3)
        learner.update(cg.Measurement(plant.time, pose=pose, wrenches={"hand": felt}, contacts=HELD))
        plant.step(cg.ContactWrenches({"hand": given}, HELD), 0.01)
    return learner


@pytest.mark.long
@pytest.mark.parametrize("share", [0.0, 0.2])
def test_what_rows_leave_free_is_not_decided_by_noise(share):
    found = [learner_after(6.0, seed, share).estimate.parameters["mass"] for seed in (0, 1, 3)]
    off = np.array([(mass.value - 60.0) / mass.std for mass in found])
    assert np.sqrt((off**2).mean()) < 3.0


@pytest.mark.long
def test_pushed_straight_at_first_it_is_told():
    """What rows taught is known; what is told may be wider, while a load is tried."""
    masses = [learner_after(9.0, seed, 0.2, 3.0).estimate.parameters["mass"] for seed in (0, 1, 3)]
    learned = [learner_after(9.0, seed, 0.2, 3.0, RegressorEstimator).belief for seed in (0, 1, 3)]
    assert max(abs(mass.value - 60.0) / mass.std for mass in masses) < 3.0
    assert max(mass.covariance[0, 0] ** 0.5 for mass in learned) < 0.5
    typical, one_that_tries_a_load = sorted(mass.std for mass in masses)[1:]
    assert typical < 0.2
    assert one_that_tries_a_load < 1.0
