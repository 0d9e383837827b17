"""Variants of measured logs: what each changes and what it leaves, on logs whose motion is a closed form."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.measured import variants
from benchmarks.measured.logs import LOGS
from benchmarks.measured.variants import FAST_CLOCK, VARIANTS
from cartgrasp.errors import DataError
from cartgrasp.logs import ArmLog, RunLog

from .measured_logs import parabola

TIME = np.arange(1003) / 240.0


def same(one, other):
    """Whether two logs hold the same rows."""
    if one.columns != other.columns or len(one) != len(other):
        return False
    return bool(np.array_equal(one.table, other.table, equal_nan=True))


def true_pose(time):
    pose = parabola(time).pose
    return pose[:, :2], np.exp(1j * pose[:, 2])


def test_there_are_many_of_them_and_each_has_its_name():
    names = [variant.name for variant in VARIANTS]
    assert len(set(names)) == len(names)
    assert sum(len(log.variants()) - 1 for log in LOGS) >= 50
    assert sum(len(log.variants()) - 1 for log in LOGS if "force" in log.has) >= 50
    assert all(log.idle <= set(names) for log in LOGS)


@pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)
def test_each_changes_something_the_same_each_time_and_not_what_it_is_given(variant):
    log, untouched = parabola(TIME), parabola(TIME)
    changed = variant.change(log)
    assert same(log, untouched)
    assert same(changed, variant.change(log))
    assert same(changed, log) == (variant.guess is not None)


@pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)
def test_each_takes_a_log_without_velocities_and_one_without_arms(variant):
    log = parabola(TIME, velocity=False)
    made = variant.name.startswith("velocities") and variant.name != "velocities left out"
    assert (variant.change(log).velocity is None) != made
    try:
        coasting = RunLog(log.time, log.pose, None, {}, "coasting")
    except DataError as error:
        pytest.skip(f"a log without arms is refused: {error}")
    assert not variant.change(coasting).arms


def test_rows_are_left_out():
    log = parabola(TIME)
    np.testing.assert_array_equal(variants.every(log, 3).table, log.table[::3])
    first, last = variants.first_part(log, 0.6), variants.last_part(log, 0.6)
    assert first.time[0] == log.time[0]
    assert last.time[-1] == log.time[-1]
    for part in (first, last):
        assert part.duration == pytest.approx(0.6 * log.duration, abs=1 / 240)
    assert first.time[-1] > last.time[0]


def test_means_are_of_whole_groups_and_angles_take_the_short_way():
    """Means of two rows of a parabola miss it by its second derivative times h²/8."""
    log = parabola(TIME)
    mean = variants.averaged(log, 2)
    assert len(mean) == len(log) // 2
    places, turned = true_pose(mean.time)
    np.testing.assert_allclose(mean.pose[:, :2], places, atol=0.41 / 240**2 / 8)
    np.testing.assert_allclose(np.exp(1j * mean.pose[:, 2]), turned, atol=0.11 / 240**2 / 8)
    assert np.abs(np.diff(log.pose[:, 2])).max() > 6  # the log's angles do wrap
    wrench = parabola(mean.time).arms["left"].wrench
    np.testing.assert_allclose(mean.arms["left"].wrench, wrench, rtol=1e-12)


@pytest.mark.parametrize("rate", [100.0, 50.0])
def test_resampling_lies_between_the_rows(rate):
    """Straight lines between rows of a parabola miss it by its second derivative times h²/8."""
    log = parabola(TIME)
    even = variants.resampled(log, rate)
    np.testing.assert_allclose(np.diff(even.time), 1 / rate, rtol=1e-9)
    assert log.duration - 2 / rate < even.duration < log.duration
    places, turned = true_pose(even.time)
    np.testing.assert_allclose(even.pose[:, :2], places, atol=0.41 / 240**2 / 8)
    np.testing.assert_allclose(np.exp(1j * even.pose[:, 2]), turned, atol=0.11 / 240**2 / 8)
    np.testing.assert_allclose(even.velocity, parabola(even.time).velocity, atol=1e-12)
    np.testing.assert_allclose(even.arms["left"].wrench, parabola(even.time).arms["left"].wrench, rtol=1e-9)


@pytest.mark.parametrize("step", [0.001, 0.005])
def test_places_are_printed_to_a_step(step):
    log = parabola(TIME)
    printed = variants.printed_places(log, step).pose
    assert np.abs(printed[:, :2] - log.pose[:, :2]).max() <= step / 2 * (1 + 1e-9)
    steps = printed[:, :2] / step
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    np.testing.assert_array_equal(printed[:, 2], log.pose[:, 2])


def test_times_are_printed_and_rows_of_one_time_are_one():
    log = parabola(np.array([0.0, 0.0004, 0.0013, 0.0021, 0.004]))
    printed = variants.printed_times(log, 3)
    np.testing.assert_allclose(printed.time, [0.0, 0.001, 0.002, 0.004])
    np.testing.assert_array_equal(printed.pose, log.pose[[0, 2, 3, 4]])


def test_a_fast_clock_makes_a_millisecond_more_than_one():
    log = parabola(np.arange(500) / 1000)
    fast = variants.by_clock(log, FAST_CLOCK)
    assert np.median(np.diff(fast.time)) == pytest.approx(0.001000008, abs=1e-12)
    np.testing.assert_array_equal(fast.pose, log.pose)


numbers = st.floats(-2, 2)


@given(st.lists(st.tuples(numbers, numbers, numbers), min_size=3, max_size=3), st.integers(0, 2**31), st.booleans())
def test_velocities_of_a_parabola_are_its_slope_at_any_times(coefficients, seed, even):
    steps = np.full(300, 0.005) if even else np.random.default_rng(seed).uniform(0.002, 0.008, 300)
    log = parabola(np.cumsum(steps), *coefficients)
    made = variants.with_velocities(variants.without_velocities(log))
    np.testing.assert_allclose(made.velocity, log.velocity, atol=1e-9)


def test_velocities_come_late_and_large():
    log = parabola(TIME)
    late = variants.with_velocities(log, late=0.05)
    inside = TIME > 0.05
    np.testing.assert_allclose(late.velocity[inside], parabola(TIME - 0.05).velocity[inside], atol=1e-9)
    large = variants.with_velocities(log, scale=1.03)
    np.testing.assert_allclose(large.velocity, 1.03 * log.velocity, atol=1e-9)


def test_too_few_rows_make_no_velocities():
    with pytest.raises(DataError, match="3 rows"):
        variants.with_velocities(parabola(np.array([0.0, 0.1, 0.2])))


def test_noise_is_a_share_of_each_component():
    """Of 24,000 numbers, the standard deviation's own is 0.5 %; a component that is zero stays so."""
    log = parabola(np.arange(24000) / 240)
    added = variants.with_noise(log, 0.05).arms["left"].wrench - log.arms["left"].wrench
    size = np.sqrt(np.mean(log.arms["left"].wrench ** 2, axis=0))
    np.testing.assert_allclose(added.std(axis=0), 0.05 * size, rtol=0.02)
    assert np.abs(added.mean(axis=0)).max() <= 0.05 * size.max() * 4 / np.sqrt(24000)


def test_each_arm_has_noise_of_its_own():
    log = parabola(TIME)
    left = log.arms["left"]
    two = RunLog(log.time, log.pose, None, {"right": ArmLog(left.contact, left.wrench), "left": left})
    noisy = variants.with_noise(two, 0.05).arms
    assert list(noisy) == ["right", "left"]
    added = [noisy[arm].wrench[:, 0] - left.wrench[:, 0] for arm in noisy]
    assert abs(np.corrcoef(*added)[0, 1]) < 5 / np.sqrt(len(TIME))
