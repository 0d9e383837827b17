"""Pose noise that remembers, by other roads: dense Gaussian processes, differences, and the tests' own equations."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.logs import ArmLog, RunLog
from estimation.batch.motion_smoother import smooth_motion
from estimation.batch.pose_colour import PoseColour, SlowNoise
from estimation.log_noise import noise_of_log
from estimation.variogram import Variogram, in_third_differences

from .runs import STEP
from .test_coloured_poses import GUESS, SLOW, WHITE, recorded, remembering


def smoothed(log):
    return smooth_motion(log, GUESS, noise_of_log(log, GUESS))


# --- which noise it is --------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("time", [0.1, 0.25])
def test_the_colour_is_found(seed, time):
    colour = smoothed(recorded(seed, time=time)).slow.colour
    assert colour.position**2 / colour.time == pytest.approx(SLOW**2 / time, rel=0.5)
    assert colour.position == pytest.approx(SLOW, rel=0.4)
    assert colour.heading == pytest.approx(SLOW, rel=0.6)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("velocity", [False, True])
def test_white_noise_stays_white(seed, velocity):
    assert smoothed(recorded(seed, slow=0.0, velocity=velocity)).slow is None


@pytest.mark.parametrize("seed", range(3))
def test_a_cart_that_slips_in_curves_is_no_noise(seed):
    """Its side force is answered by a sideways speed, which the poses of the tests' cart then follow."""
    log = recorded(seed, slow=0.0)
    steps = np.diff(log.pose, axis=0, prepend=log.pose[:1])
    smooth = np.ones(40) / 40
    turned, went = (np.convolve(c, smooth, "same") for c in (steps[:, 2], np.hypot(steps[:, 0], steps[:, 1])))
    aside = np.cumsum(-40.0 * turned * went / STEP)  # 0.4 m/s at 1 m/s and 1 rad/s
    turn = log.pose[:, 2]
    way = np.cumsum(np.stack([-np.sin(turn), np.cos(turn)], axis=1) * np.diff(aside, prepend=0.0)[:, None], axis=0)
    assert np.abs(aside).max() > 0.05
    pose = np.column_stack([log.pose[:, :2] + way, log.pose[:, 2]])
    assert smoothed(replace(log, pose=pose)).slow is None


def free(seed, **given):
    """The same log, to somebody who does not know that the cart has an axle."""
    log, cart = recorded(seed, **given), replace(GUESS, constraints=RollingConstraints(axle_x=None))
    return smooth_motion(log, cart, noise_of_log(log, cart))


@pytest.mark.parametrize("velocity", [False, True])
@pytest.mark.parametrize("time", [0.05, 0.1, 0.25])
def test_the_colour_is_found_where_no_axle_tells(time, velocity):
    colour = free(1, time=time, velocity=velocity).slow.colour
    assert colour.position**2 / colour.time == pytest.approx(SLOW**2 / time, rel=0.5)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("velocity", [False, True])
def test_white_noise_stays_white_where_no_axle_tells(seed, velocity):
    assert free(seed, slow=0.0, velocity=velocity).slow is None


@pytest.mark.parametrize("power", [3, 4, 5, 6])
def test_motion_is_no_noise(power):
    """Jumps of velocity, of acceleration, white jerk and smooth motion, each with white noise, by their variograms."""
    lag = STEP * np.array([1, 2, 3, 4, 6, 8, 12])
    shown = Variogram(lag, WHITE**2 + (0.002 * (lag / lag[-1]) ** (power / 2)) ** 2)
    assert shown.beside_motion(None) == (pytest.approx([WHITE**2]), pytest.approx(0.0, abs=1e-6))
    slow = replace(shown, value=shown.value + SLOW**2 * in_third_differences(np.exp(-lag / 0.1)))
    assert slow.beside_motion(None)[1] > 0.1
    assert slow.beside_motion(0.1)[0] == pytest.approx([WHITE**2, SLOW**2], rel=1e-3)


def test_third_differences_are_in_units_of_white_noise():
    random = np.random.default_rng(0)
    noise = 0.4 * random.standard_normal((200000, 2)) + 0.9 * remembering(200000, random, 0.05)[:, :2]
    shown = Variogram.of_third_differences(STEP * np.arange(len(noise)), noise)
    expected = 0.4**2 + 0.9**2 * in_third_differences(np.exp(-shown.lag / 0.05))
    np.testing.assert_allclose(shown.value, expected, rtol=0.03)


def test_white_noise_is_what_third_differences_leave():
    """Of an autoregression and white noise, drawn long: the deviation that they show together."""
    random = np.random.default_rng(0)
    noise = 0.4 * random.standard_normal((400000, 3)) + 0.9 * remembering(400000, random, 0.05)
    shown = np.diff(noise, 3, axis=0).std(axis=0)[[0, 2]] / 20**0.5
    assert PoseColour(0.9, 0.9, 0.05).white(shown, STEP) == pytest.approx(0.4, rel=0.01)


# --- the smoother with it -----------------------------------------------------------------------------------


def turning_on_the_spot(n=460, seed=0):
    """Yaw is driven by white jerk; x and y stay, so that the chain is linear in all that matters."""
    random = np.random.default_rng(seed)
    rate = np.cumsum(np.cumsum(0.5 * STEP**0.5 * random.standard_normal(n)) * STEP)
    truth = np.column_stack([np.zeros(n), np.zeros(n), np.cumsum(rate) * STEP])
    pose = truth + WHITE * random.standard_normal((n, 3)) + 2 * SLOW * remembering(n, random)
    arm = ArmLog(np.tile([-0.3, 0.0, 1.0], (n, 1)), np.zeros((n, 6)))
    return RunLog(STEP * np.arange(n), pose, None, {"hand": arm})


@cache
def yaw_by_dense_algebra():
    """A log, its smoothed motion, and by covariances of a Gaussian process, at all rows: the gain (2 n, n) from
    measured headings to yaw rate and acceleration, their covariance, and that of the headings' noise."""
    log = turning_on_the_spot()
    motion, noise = smoothed(log), noise_of_log(log, GUESS)
    n, colour = len(log), motion.slow.colour
    step = np.array([[1.0, STEP, STEP**2 / 2], [0.0, 1.0, STEP], [0.0, 0.0, 1.0]])
    q = motion.jerk[0, 1] ** 2
    powers = np.array([[5, 4, 3], [4, 3, 2], [3, 2, 1]])
    drive = q * STEP**powers / np.array([[20.0, 8.0, 6.0], [8.0, 3.0, 2.0], [6.0, 2.0, 1.0]])
    drive[0, 0] += noise.slip**2 * STEP
    here, joint = np.diag([1e4, 1e2, 1e4]) / 10.0, np.zeros((n, 3, n, 3))
    for i in range(n):
        joint[i, :, i] = here
        for j in range(i + 1, n):
            joint[j, :, i] = step @ joint[j - 1, :, i]
            joint[i, :, j] = joint[j, :, i].T
        here = step @ here @ step.T + drive
    white = colour.white(np.array([noise.position, noise.heading]), STEP)[1]
    apart = np.abs(np.subtract.outer(log.time, log.time))
    errors = white**2 * np.eye(n) + colour.heading**2 * np.exp(-apart / colour.time)
    wanted = joint[:, 1:].transpose(1, 0, 2, 3).reshape(2 * n, n, 3)[:, :, 0]
    gain = np.linalg.solve(joint[:, 0, :, 0] + errors, wanted.T).T
    own = joint[:, 1:, :, 1:].transpose(1, 0, 3, 2).reshape(2 * n, 2 * n)
    return log, motion, gain, own - gain @ wanted.T, errors


def test_the_motion_is_that_of_a_dense_smoother():
    log, motion, gain, covariance, _ = yaw_by_dense_algebra()
    n, found = len(log), np.concatenate([motion.velocity[:, 1], motion.acceleration[:, 1]])
    assert not (motion.jerk != motion.jerk[0]).any()
    std = np.sqrt(np.diagonal(covariance))
    assert np.abs((found - gain @ log.pose[:, 2]) / std).max() < 0.03
    at = n // 2
    one = np.zeros((n, 10, 2))
    one[at, 4, 0] = one[at, 6, 1] = 1.0
    believed = np.sqrt(np.diagonal(motion.information.factor().solve(one)[at, [4, 6]]))
    assert believed == pytest.approx(std[[at, n + at]], rel=0.02)


def test_what_noise_does_to_the_motion_is_drawn():
    _, motion, gain, _, errors = yaw_by_dense_algebra()
    expected = np.sqrt(np.diagonal(gain @ errors @ gain.T)).reshape(2, -1)[:, 100:-100]
    random = np.random.default_rng(5)
    drawn = np.array([motion.drawn_rows(random)[100:-100, [4, 6]] for _ in range(60)])
    assert drawn.std(axis=(0, 1)) == pytest.approx(expected.mean(axis=1), rel=0.08)


def test_slow_noise_is_drawn_with_its_covariance():
    """Also over steps that are not alike, and not from one piece of a log to another."""
    steps = np.array([0.01, 0.05, 0.5, 0.02])
    slow = SlowNoise.of(PoseColour(2.0, 3.0, 0.1), steps, steps < 0.3)
    random = np.random.default_rng(0)
    drawn = np.array([slow.drawn(random) for _ in range(20000)])
    time = np.append(0.0, np.cumsum(steps))
    piece = np.array([0, 0, 0, 1, 1])
    together = piece[:, None] == piece
    expected = np.exp(-np.abs(np.subtract.outer(time, time)) / 0.1) * together
    for i, std in enumerate((2.0, 2.0, 3.0)):
        assert np.cov(drawn[:, :, i].T) / std**2 == pytest.approx(expected, abs=0.04)
    determinant = np.linalg.slogdet(expected)[1]
    assert slow.log_determinant == pytest.approx(-3 * determinant - 10 * np.log([2.0, 2.0, 3.0]).sum(), rel=1e-9)
