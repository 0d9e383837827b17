"""Velocity noise that remembers: its long means and differences by drawing, and what a log teaches beside it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from cartgrasp.constraints import RollingConstraints
from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.log_noise.log_noise import noise_floor, noise_of_log
from estimation.log_noise.velocity_autocorrelation import noise_scale
from estimation.whole_log.identification import identify

from ..runs import STEP, simulate_two_hands

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
GUESS = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(linear=2.0, angular=1.0),))


def remembering(n, random, time):
    """Noise (n, 3) of unit variance that fades with a correlation time."""
    fade = np.exp(-STEP / time)
    white = random.standard_normal((n, 3))
    white[1:] *= (1 - fade**2) ** 0.5
    return lfilter([1.0], [1.0, -fade], white, axis=0)


def recorded(seed, time, size=0.008, duration=40.0):
    """A log whose velocities have noise of `size` (m/s, rad/s) that fades; white where `time` is none."""
    log, random = simulate_two_hands(TRUTH, seed, duration, noise=(0.001, 0.0, 2.0)), np.random.default_rng(7 + seed)
    noise = random.standard_normal((len(log), 3)) if time is None else remembering(len(log), random, time)
    return replace(log, velocity=log.velocity + size * noise)


def heard(log, cart=GUESS):
    return noise_of_log(log, cart).linear_velocity / max(noise_floor(log.velocity[:, i]) for i in (0, 1))


@pytest.mark.parametrize("time", [0.015, 0.03, 0.08])
@pytest.mark.parametrize("white", [0.0, 0.3])
def test_long_means_scatter_as_those_of_white_noise_so_loud(time, white):
    """Means of 4 s of 20,000 s of noise, beside its third differences."""
    random = np.random.default_rng(3)
    noise = remembering(2_000_000, random, time)[:, 0] + white * random.standard_normal(2_000_000)
    means = noise.reshape(-1, 400).mean(axis=1).std() * 400**0.5
    shown = np.diff(noise, 3).std() / 20**0.5
    assert noise_scale(STEP * np.arange(100_000), noise[:100_000]) == pytest.approx(means / shown, rel=0.15)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(6))
def test_white_noise_is_as_loud_as_it_looks(seed):
    assert heard(recorded(seed, None)) == pytest.approx(1.0)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("time", [0.02, 0.06])
def test_a_log_tells_how_loud_it_is(seed, time):
    fade = np.exp(-STEP / time)
    share = 1 - 1.5 * fade + 0.6 * fade**2 - 0.1 * fade**3
    expected = ((1 + fade) / (1 - fade) / share) ** 0.5
    assert heard(recorded(seed, time)) == pytest.approx(expected, rel=0.4)


def test_a_cart_that_creeps_in_curves_is_no_noise():
    log = recorded(2, None)
    turn, (forward, yaw) = log.pose[:, 2], (np.hypot(*log.velocity[:, :2].T), log.velocity[:, 2])
    aside = 0.3 * np.convolve(forward * yaw, np.ones(30) / 30, "same")
    creep, velocity, pose = np.zeros((len(log), 2)), log.velocity.copy(), log.pose.copy()
    creep += aside[:, None] * np.column_stack([-np.sin(turn), np.cos(turn)])
    velocity[:, :2] += creep
    pose[:, :2] += STEP * np.cumsum(creep, axis=0)
    assert np.abs(aside).max() > 0.05
    assert heard(replace(log, velocity=velocity, pose=pose)) == pytest.approx(1.0)


def test_a_cart_on_casters_is_heard_by_its_poses_and_a_short_log_is_taken_as_it_looks():
    log, on_casters = recorded(0, 0.06), replace(GUESS, constraints=RollingConstraints(axle_x=None))
    assert heard(log, on_casters) == pytest.approx(heard(log), rel=0.4)
    assert heard(recorded(0, None), on_casters) == pytest.approx(1.0)
    assert noise_scale(log.time[:150], log.velocity[:150, 1]) == 1.0


@pytest.mark.some(1)
@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_the_load_is_found_beside_it(seed):
    found = identify([recorded(seed, 0.05)], GUESS).parameters.values()
    z = np.array([(p.value - v) / p.std for p, v in zip(found, TRUTH[:6], strict=True)])
    assert np.abs(z).max() < 3.5
    assert next(iter(found)).value == pytest.approx(24.0, rel=0.04)
