"""Single samples that are off, among sensors' noise: neither followed nor taken for a jolt; a jolt is none of them."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation import FilterNoise
from estimation.whole_log.identification import identify

from ..runs import simulate

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
NOISE = FilterNoise(0.0004, 0.0004, 0.005, 0.005)
NAMES = ("mass", "com_x", "com_y", "inertia")


def guess(mass=21.0, com=(0.3, 0.0), inertia=1.8):
    return CartModel(Inertia(mass, com, inertia), effects=(ViscousDrag(linear=2.5, angular=1.0),))


def spoiled(log, seed, share=0.005, size=0.06):
    """With jumps of the velocity in some rows, most of them of some deviations only."""
    random = np.random.default_rng(1000 + seed)
    rows = random.random(len(log)) < share
    velocity = log.velocity + rows[:, None] * size * random.standard_normal((len(log), 3))
    return replace(log, velocity=velocity), rows


def scores(found):
    parameters = found.parameters
    return [(parameters[n].value - v) / parameters[n].std for n, v in zip(NAMES, TRUTH, strict=False)]


@pytest.mark.some(1)
@pytest.mark.parametrize("seeds", [5, pytest.param(20, marks=pytest.mark.prove)])
@pytest.mark.parametrize("curved", [False, True])
def test_intervals_hold_over_seeds(curved, seeds):
    """Straight motion yaws by little beyond its noise, and says little of the inertia: 0.3 where curves say 0.1. It was
    0.4 and more before wrenches might be late; of 60 seeds errors are 0.76 of what is told."""
    z, stds = [], []
    for seed in range(seeds):
        log = spoiled(simulate(TRUTH, seed, curved=curved, noise=(0.0004, 0.005, 1.0))[0], seed)[0]
        found = identify([log], guess())
        z.append(scores(found))
        stds.append([found.parameters[name].std for name in NAMES])
    z = np.array(z)
    assert np.abs(z).max() < 4.0
    assert np.sqrt((z**2).mean()) < 1.25
    assert np.sqrt((z**2).mean(axis=0)).max() < 1.5
    assert (np.abs(z) < 1.96).mean() >= 0.9
    mass, _, _, inertia = np.median(stds, axis=0)
    assert mass < 0.2
    assert inertia < 0.1 if curved else inertia > 0.25
