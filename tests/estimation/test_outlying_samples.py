"""Single samples that are off, among sensors' noise: neither followed nor taken for a jolt; a jolt is none of them."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel
from estimation import FilterNoise
from estimation.batch.motion_smoother import smooth_motion
from estimation.identification import identify

from .runs import simulate

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


def acceleration_error(log, truth):
    motion = smooth_motion(log, guess(), NOISE)
    rate = np.gradient(truth[:, 3:], log.time, axis=0)
    return np.sqrt(((motion.acceleration - rate) ** 2).mean(axis=0)), motion


@pytest.mark.parametrize("curved", [False, True])
def test_the_motion_is_smoothed_as_if_they_were_not_there(curved):
    log, truth = simulate(TRUTH, 3, curved=curved)
    other, rows = spoiled(log, 3)
    assert rows.sum() > 4
    clean, spoilt = acceleration_error(log, truth)[0], acceleration_error(other, truth)[0]
    assert spoilt == pytest.approx(clean, rel=0.15)


def test_a_pose_that_jumps_moves_nothing_else():
    log, truth = simulate(TRUTH, 4, 6.0)
    pose = log.pose.copy()
    pose[[200, 380], [0, 2]] += 0.008
    clean, spoilt = acceleration_error(log, truth)[0], acceleration_error(replace(log, pose=pose), truth)[0]
    assert spoilt == pytest.approx(clean, rel=0.1)


def bump(seed):
    """A cart that rolls at 0.8 m/s and is stopped within a row, halfway."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, 6.0, 0.01)
    speed = np.where(time < 3.0, 0.8, 0.0)
    pose = np.column_stack([np.minimum(time, 3.0) * 0.8, 0 * time, 0 * time])
    velocity = np.column_stack([speed, 0 * time, 0 * time])
    noisy = pose + 0.0004 * random.standard_normal(pose.shape), velocity + 0.005 * random.standard_normal(pose.shape)
    return RunLog(time, *noisy, {"hand": ArmLog(np.zeros_like(pose), np.zeros((len(time), 6)))}), speed


def test_a_cart_that_hits_a_wall_is_seen_to_stop():
    log, speed = bump(0)
    motion = smooth_motion(log, guess(), NOISE)
    assert np.abs(motion.velocity[:, 0] - speed)[np.abs(log.time - 3.0) > 0.045].max() < 0.05


def scores(found):
    parameters = found.parameters
    return [(parameters[n].value - v) / parameters[n].std for n, v in zip(NAMES, TRUTH, strict=False)]


@pytest.mark.parametrize("curved", [False, True])
def test_intervals_hold_over_20_seeds(curved):
    """Straight motion yaws by little beyond its noise: what that can't teach stays as it was believed."""
    z, stds = [], []
    for seed in range(20):
        log = spoiled(simulate(TRUTH, seed, curved=curved, noise=(0.0004, 0.005, 1.0))[0], seed)[0]
        found = identify([log], guess())
        z.append(scores(found))
        stds.append([found.parameters[name].std for name in NAMES])
    z = np.array(z)
    assert np.abs(z).max() < 4.0
    assert np.sqrt((z**2).mean()) < 1.25
    assert (np.abs(z) < 1.96).mean() > 0.9
    mass, _, _, inertia = np.median(stds, axis=0)
    assert mass < 0.2
    assert inertia < 0.1 if curved else inertia > 0.4
