"""Velocities that are late, too large, or of other axes and units: found with the right value, and put right."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimation.sensor_check.velocities import Rates, clock, corrected_velocities
from estimation.sensor_check.windows import Track

from .logs import NOISE, QUIET, found, late, on_rail, sealed, two_hands

SEEDS = st.integers(0, 3)


def clocks(log):
    track = Track.of(log)
    return [clock(Rates.of(track, log.time, log.velocity[:, which])) for which in (slice(0, 2), slice(2, 3))]


def told(log):
    return corrected_velocities(log)[1]


@pytest.mark.long
@settings(max_examples=12)
@given(SEEDS, st.floats(-0.1, 0.15), st.floats(0.8, 1.25))
def test_lag_and_scale_are_found(seed, lag, gain):
    """2 ms and 0.3 % are what a filter needs; the fits tell a fifth of it, and mean it."""
    for fit in clocks(late(two_hands(seed), lag, gain)):
        assert fit.lag == pytest.approx(lag, abs=0.002)
        assert fit.gain == pytest.approx(gain, rel=0.003)
        assert abs(fit.lag - lag) < 5 * fit.lag_std < 0.005
        assert abs(fit.gain - gain) < 5 * fit.gain_std < 0.01


@pytest.mark.long
def test_deviations_are_honest():
    """Over many seeds errors are as large as is said: a half more or a half less, with 24 draws of two sensors."""
    fits = [fit for seed in range(100, 124) for fit in clocks(two_hands(seed))]
    errors = np.array([[fit.lag / fit.lag_std, (fit.gain - 1) / fit.gain_std] for fit in fits])
    size = np.sqrt((errors**2).mean(axis=0))
    assert (size < 1.5).all()
    assert (size > 0.5).all()


@pytest.mark.long
@pytest.mark.some(4)
@pytest.mark.parametrize(
    ("lag", "gain"), [(0.01, 1.0), (0.02, 1.0), (0.05, 1.0), (0.0, 1.03), (0.0, 1.05), (-0.03, 0.96)]
)
@pytest.mark.parametrize(("case", "seed"), [("nothing", 1), ("lateral_slip", 0), ("payload_change", 3)])
def test_what_is_wrong_is_told_and_put_right(case, seed, lag, gain):
    log, _ = sealed(case, seed)
    right, suspicions = corrected_velocities(late(log, lag, gain))
    kinds = ({"lag"} if lag else set()) | ({"scale"} if gain != 1 else set())
    assert found(suspicions).keys() == {(kind, where) for kind in kinds for where in ("velocity", "yaw_rate")}
    assert all(one.probability > 0.9 and one.put_right for one in suspicions)
    assert told(right) == ()


@pytest.mark.long
@pytest.mark.some(4)
@pytest.mark.parametrize("is_rough", [False, True])
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("case", ["nothing", "time_delay", "wheel_misalignment", "lateral_slip"])
def test_nothing_is_told_of_sound_logs(case, seed, is_rough):
    log, _ = sealed(case, seed, is_rough)
    right, suspicions = corrected_velocities(log)
    assert suspicions == ()
    assert right.velocity is log.velocity or np.array_equal(right.velocity, log.velocity, equal_nan=True)


@pytest.mark.long
@settings(max_examples=5)
@given(SEEDS, st.floats(0.02, 0.1), st.floats(1.03, 1.2))
def test_put_right_is_as_it_was(seed, lag, gain):
    """With velocities of no noise, cubics between rows give back what was there, but for kinks between rows."""
    sound = two_hands(seed, QUIET)
    right, _ = corrected_velocities(late(sound, lag, gain))
    inside = slice(20, -20)
    assert np.isfinite(right.velocity[inside]).all()
    error = right.velocity[inside] - sound.velocity[inside]
    assert np.sqrt((error**2).mean()) < 5e-4


def test_rows_without_velocities_stay_without():
    log = late(two_hands(0), 0.05)
    velocity = log.velocity.copy()
    velocity[1000:1100] = np.nan
    right, _ = corrected_velocities(replace(log, velocity=velocity))
    assert np.isnan(right.velocity[1000:1090]).all()
    assert np.isfinite(right.velocity[200:900]).all()


@pytest.mark.parametrize("every", [2, 5])
def test_late_velocities_of_a_slower_sensor_are_kept(every):
    """Blank in all rows between: not one was left of them, where they were put right."""
    log = two_hands(0)
    fresh = np.arange(len(log)) % every == 0
    right, suspicions = corrected_velocities(
        replace(log, velocity=np.where(fresh[:, None], late(log, 0.03).velocity, np.nan))
    )
    assert ("lag", "velocity") in found(suspicions)
    seen = np.isfinite(right.velocity).all(axis=1)
    assert fresh.sum() - 2 <= seen.sum() <= fresh.sum()
    assert np.sqrt(((right.velocity - log.velocity)[seen] ** 2).mean()) < 2 * NOISE[1]


def test_velocities_of_another_point_are_no_other_scale():
    """A velocity 0.3 m ahead of the tracked point differs by omega times that, which is neither late nor too large."""
    log, theta = two_hands(0, NOISE), two_hands(0).pose[:, 2]
    omega = two_hands(0, QUIET).velocity[:, 2:]
    ahead = 0.3 * omega * np.column_stack([-np.sin(theta), np.cos(theta)])
    assert told(replace(log, velocity=np.column_stack([log.velocity[:, :2] + ahead, log.velocity[:, 2]]))) == ()


@pytest.mark.long
@given(st.integers(0, 2**32 - 1), st.floats(2.0, 8.0))
@settings(max_examples=8)
def test_a_speed_that_fades_evenly_tells_no_lag(seed, fading):
    """exp(-(t - lag) / fading) is exp(-t / fading) times a scale: nobody can tell which."""
    time, random = 0.01 * np.arange(2000), np.random.default_rng(seed)
    speed, zero = np.exp(-time / fading), np.zeros(2000)
    pose = np.column_stack([-fading * speed, zero, zero]) + 5e-4 * random.standard_normal((2000, 3))
    velocity = np.column_stack([speed, zero, zero]) + 5e-3 * random.standard_normal((2000, 3))
    assert told(replace(on_rail(), time=time, pose=pose, velocity=velocity, arms={})) == ()


def test_a_cart_that_stands_tells_nothing():
    log, random = two_hands(0), np.random.default_rng(0)
    assert told(replace(log, pose=5e-4 * random.standard_normal(log.pose.shape), velocity=log.velocity * 0)) == ()
    assert told(replace(log, velocity=np.full_like(log.pose, np.nan))) == ()
    assert told(replace(log, velocity=None)) == ()


def in_the_carts_frame(log):
    c, s = np.cos(log.pose[:, 2]), np.sin(log.pose[:, 2])
    vx, vy, omega = log.velocity.T
    return replace(log, velocity=np.column_stack([c * vx + s * vy, c * vy - s * vx, omega]))


def of(change):
    return lambda log: replace(log, velocity=change(log.velocity))


FAULTS = {
    "in mm/s": ("unit", "velocity", of(lambda v: v * [1000, 1000, 1])),
    "in km/h": ("unit", "velocity", of(lambda v: v * [3.6, 3.6, 1])),
    "in deg/s": ("unit", "yaw_rate", of(lambda v: v * [1, 1, 180 / np.pi])),
    "of places in mm": ("unit", "pose", lambda log: replace(log, pose=log.pose * [1000, 1000, 1])),
    "of the cart": ("frame", "velocity", in_the_carts_frame),
    "swapped": ("axes", "velocity", of(lambda v: v[:, [1, 0, 2]])),
    "reversed": ("sign", "velocity", of(lambda v: v * [-1, -1, 1])),
    "of y reversed": ("sign", "velocity", of(lambda v: v * [1, -1, 1])),
    "of yaw reversed": ("sign", "yaw_rate", of(lambda v: v * [1, 1, -1])),
}


@pytest.mark.parametrize("name", FAULTS)
def test_other_axes_and_units_are_told_with_the_cure_and_left(name):
    kind, where, change = FAULTS[name]
    wrong = change(two_hands(0))
    right, suspicions = corrected_velocities(wrong)
    assert found(suspicions).keys() == {(kind, where)}
    assert suspicions[0].is_refused
    assert any(cure in suspicions[0].words for cure in ("multiply", "exchange", "turn"))
    assert np.array_equal(right.velocity, wrong.velocity)


@pytest.mark.long
@settings(max_examples=4)
@given(SEEDS, st.floats(0.7, 1.4))
def test_scales_are_no_units(seed, gain):
    assert {kind for kind, _ in found(told(of(lambda v: gain * v)(two_hands(seed))))} <= {"scale"}
