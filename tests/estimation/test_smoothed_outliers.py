"""Single samples that are off, in the motion that the batch fit smoothes."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.logs import ArmLog, RunLog
from estimation import FilterNoise
from estimation.batch.motion_smoother import smooth_motion

from .runs import simulate
from .test_outlying_samples import TRUTH, guess, spoiled

NOISE = FilterNoise(0.0004, 0.0004, 0.005, 0.005)


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
