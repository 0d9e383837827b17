"""Velocities that are late or too large: found with the right value, put right, and not told of sound ones."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimation.sensor_check import velocities_put_right
from estimation.sensor_check.motion.velocity_clock import late_or_scaled, linear_clock, yaw_clock
from estimation.sensor_check.recorder.jumps import without_jumps

from .sensor_logs import NOISE, QUIET, found, late, sealed, two_hands

SEEDS = st.integers(0, 3)


@settings(max_examples=30)
@given(SEEDS, st.floats(-0.1, 0.15), st.floats(0.8, 1.25))
def test_lag_and_scale_are_found(seed, lag, gain):
    """2 ms and 0.3 % are what a filter needs; the fits tell a fifth of it, and mean it."""
    log = late(two_hands(seed), lag, gain)
    for fit in (linear_clock(log), yaw_clock(log)):
        assert fit.lag == pytest.approx(lag, abs=0.002)
        assert fit.gain == pytest.approx(gain, rel=0.003)
        assert fit.lag_std < 5e-4
        assert fit.gain_std < 1e-3
        assert abs(fit.lag - lag) < 5 * fit.lag_std
        assert abs(fit.gain - gain) < 5 * fit.gain_std


def test_deviations_are_honest():
    """Over many seeds errors are as large as is said: a fifth more or a third less, with 24 draws."""
    fits = [linear_clock(two_hands(seed)) for seed in range(100, 124)]
    errors = np.array([[fit.lag / fit.lag_std, (fit.gain - 1) / fit.gain_std] for fit in fits])
    assert (np.sqrt((errors**2).mean(axis=0)) < 1.5).all()
    assert (np.sqrt((errors**2).mean(axis=0)) > 0.6).all()


@pytest.mark.parametrize(("lag", "gain"), [(0.02, 1.0), (0.05, 1.0), (0.0, 1.03), (0.0, 1.05), (-0.03, 0.96)])
@pytest.mark.parametrize(("case", "seed"), [("nothing", 1), ("lateral_slip", 0), ("payload_change", 3)])
def test_what_is_wrong_is_told(case, seed, lag, gain):
    log, _ = sealed(case, seed)
    told = found(late_or_scaled(late(log, lag, gain)))
    kinds = ({"lag"} if lag else set()) | ({"scale"} if gain != 1 else set())
    assert {kind for kind, _ in told} == kinds
    assert all(probability > 0.9 for probability in told.values())
    assert len(told) == 2 * len(kinds)


@pytest.mark.parametrize("is_rough", [False, True])
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("case", ["nothing", "time_delay", "wheel_misalignment"])
def test_nothing_is_told_of_sound_logs(case, seed, is_rough):
    log, _ = sealed(case, seed, is_rough)
    assert late_or_scaled(without_jumps(log)) == ()


@settings(max_examples=15)
@given(SEEDS, st.floats(0.02, 0.1), st.floats(1.03, 1.2))
def test_put_right_is_as_it_was(seed, lag, gain):
    """With velocities of no noise, cubics between rows give back what was there, but for kinks between rows."""
    sound = two_hands(seed, QUIET)
    right = velocities_put_right(late(sound, lag, gain))
    inside = slice(20, -20)
    assert np.isfinite(right.velocity[inside]).all()
    error = right.velocity[inside] - sound.velocity[inside]
    assert np.sqrt((error**2).mean()) < 5e-4
    assert np.abs(error).max() < 0.01
    assert late_or_scaled(right) == ()


def test_sound_velocities_are_left_alone():
    log = two_hands(0)
    assert np.array_equal(velocities_put_right(log).velocity, log.velocity)
    bare = replace(log, velocity=None)
    assert velocities_put_right(bare) is bare


def test_rows_without_velocities_stay_without():
    log = late(two_hands(0), 0.05)
    velocity = log.velocity.copy()
    velocity[1000:1100] = np.nan
    right = velocities_put_right(replace(log, velocity=velocity))
    assert np.isnan(right.velocity[1000:1090]).all()
    assert np.isfinite(right.velocity[200:900]).all()


def test_velocities_of_another_point_are_no_other_scale():
    """A velocity 0.3 m ahead of the tracked point differs by omega times that, which is neither late nor too large."""
    log = two_hands(0, NOISE)
    theta, omega = log.pose[:, 2], two_hands(0, QUIET).velocity[:, 2]
    ahead = 0.3 * omega[:, None] * np.column_stack([-np.sin(theta), np.cos(theta)])
    other = replace(log, velocity=np.column_stack([log.velocity[:, :2] + ahead, log.velocity[:, 2]]))
    assert late_or_scaled(other) == ()


def test_a_cart_that_stands_tells_nothing():
    log = two_hands(0)
    random = np.random.default_rng(0)
    still = replace(log, pose=5e-4 * random.standard_normal(log.pose.shape), velocity=log.velocity * 0)
    assert late_or_scaled(still) == ()
