"""A cart that rolls without hands tells ratios of its parameters alone: what it does to a mass that is known, and to
one that is not; and what wrenches tell of the scale, against Fisher's information, and of noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.effects import FloorSlope, RollingResistance, ViscousDrag
from cartgrasp.first_guess import FirstGuess
from cartgrasp.simulation import ModelPlant
from estimation import CartFilter, DisturbedFilter, FilterNoise, Prior
from estimation.online.kernels.row_algebra import FilteredRow
from estimation.online.regressor.parameter_scale import ScaleInformation

BED = cg.CartModel(
    cg.Inertia(100.0, (0.05, 0.02), 40.0),
    cg.RollingConstraints(),
    effects=(ViscousDrag(5.0, 3.0), RollingResistance(0.01)),
)
NOISE = FilterNoise(position=5e-4, heading=5e-4, force=2.0, moment=0.08)
HELD = {"hand": np.array([-1.0, 0.0, 0.9])}
BOTH = [CartFilter, DisturbedFilter]


def driven(learner, seed, duration, force=lambda time: 0.0, plant=None):
    """The last estimate; hands feel noise alone, or a force."""
    random, plant = np.random.default_rng(seed), plant or ModelPlant(BED, velocity=(0.9, 0.1))
    while plant.time < duration:
        wrench = {"hand": np.array([force(plant.time), 0.0, 0.0, 0.0, 0.0, 0.3 * force(plant.time)])}
        felt = {"hand": wrench["hand"] + np.array([2.0, 2.0, 2.0, 0.08, 0.08, 0.08]) * random.normal(size=6)}
        pose = plant.motion.pose_sb + 5e-4 * random.normal(size=3)
        told = learner.update(cg.Measurement(plant.time, pose=pose, wrenches=felt, contacts=HELD))
        plant.step(cg.ContactWrenches(wrench, HELD), 0.01)
    return told


@pytest.mark.parametrize("kind", BOTH)
def test_coasting_teaches_no_scale(kind):
    """It was 10 kg, the bound, and 38 ± 9 kg, called identifiable."""
    told = driven(kind(BED, ["hand"], noise=NOISE), 0, 5.0)
    mass = told.parameters["mass"]
    assert not any(one.identifiable for one in told.parameters.values())
    assert mass.std > 30.0
    assert abs(mass.value - 100.0) < mass.std


@pytest.mark.long
@pytest.mark.parametrize("kind", BOTH)
def test_after_it_pushes_teach_as_ever(kind):
    guess = BED.with_inertia(cg.Inertia(70.0, (0.0, 0.0), 25.0))
    learner = kind(guess, ["hand"], noise=NOISE, prior=Prior(slope=0.0))
    told = driven(learner, 1, 14.0, lambda time: 0.0 if time < 4.0 else 40.0 * np.sin(time))
    mass = told.parameters["mass"]
    assert mass.identifiable
    assert abs(mass.value - 100.0) < 3.0 * mass.std < 9.0


@pytest.mark.long
def test_a_mass_that_is_known_is_not_forgotten():
    """To 15 %: a `DisturbedFilter` had 70 kg after 7 s, by noise for pushes that were not there."""
    bed = replace(BED, first_guess=FirstGuess((("mass", 15.0), ("com_x", 0.1), ("com_y", 0.03), ("inertia", 15.0))))
    found = [driven(DisturbedFilter(bed, ["hand"], noise=NOISE), seed, 7.0).parameters["mass"] for seed in range(3)]
    assert np.mean([mass.value for mass in found]) > 80.0


@pytest.mark.parametrize("seed", [2, 3])
def test_where_the_mass_is_given_coasting_teaches_friction(seed):
    told = driven(CartFilter(BED, ["hand"], noise=NOISE, prior=Prior(slope=0.0, known={"mass"})), seed, 5.0)
    rolls = told.parameters["rolling_resistance.coefficient"]
    assert rolls.std < 0.001
    assert abs(rolls.value - 0.01) < 3.0 * rolls.std


@pytest.mark.parametrize("grade", [-0.01, 0.0, 0.01])
def test_rolled_one_way_a_slope_may_be_friction(grade):
    """Coasting is braked by `c + grade`. A filter that took the floor for level told 0.0203 ± 0.0003 of 0.01."""
    plant = ModelPlant(BED.with_effect(FloorSlope(grade, 0.0)), velocity=(0.9, 0.0))
    told = driven(CartFilter(BED, ["hand"], noise=NOISE, prior=Prior(known={"mass"})), 2, 5.0, plant=plant)
    rolls, slope = told.parameters["rolling_resistance.coefficient"], told.floor[0]
    assert abs(rolls.value - 0.01) < 2.0 * rolls.std
    assert rolls.std > 0.004
    assert rolls.value + slope == pytest.approx(0.01 + grade, abs=0.002)  # which is well known


def test_where_a_force_is_given_it_does_not_hold_the_mass():
    """It was 30 kg ± 4."""
    told = driven(CartFilter(BED, ["hand"], noise=NOISE, prior=Prior(known={"viscous_drag"})), 2, 5.0)
    assert told.parameters["mass"].std > 30.0


def row(noise):
    zero, flat = np.zeros((2, 2)), np.zeros(2)
    link = zero, 0.8, noise, zero, zero, zero
    return FilteredRow(flat, np.zeros((2, 5)), *link, zero, np.zeros((2, 2, 4)), zero, noise, np.zeros((2, 2, 2)), flat)


def test_what_wrenches_tell_is_the_information_on_the_logarithm_of_a_scale():
    """`y = s F + noise`: Fisher's information on log s at 1 is `Fᵀ R⁻¹ F`, in the mean over noisy F."""
    noise, force, random = np.diag([0.5, 0.1]), np.array([2.0, 0.3]), np.random.default_rng(0)
    scale, n = ScaleInformation(1e9), 4000
    for _ in range(n):
        scale = scale.after(force + np.sqrt(np.diagonal(noise)) * random.normal(size=2), row(noise))
    assert scale.told / n == pytest.approx(force @ np.linalg.inv(noise) @ force, rel=0.05)
    assert scale.by_noise / n == pytest.approx(4.0)  # twice, for two components


def test_noise_alone_is_never_taken_for_wrenches():
    noise = np.diag([0.5, 0.1])
    for seed in range(20):
        scale, random = ScaleInformation.of(BED, Prior(), np.arange(7)), np.random.default_rng(seed)
        for _ in range(1000):
            scale = scale.after(np.sqrt(np.diagonal(noise)) * random.normal(size=2), row(noise))
            assert not scale.is_known
