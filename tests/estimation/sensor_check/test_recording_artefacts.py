"""Rows written again or put in between, steps of encoders, rows too slow: told where they are, and not elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.frames import wrap_angle
from cartgrasp.logs import RunLog
from estimation.sensor_check import check_sensors, corrected_log, look_at
from estimation.sensor_check.recording_artefacts import interpolated, quantised, slow, step_of

from .logs import CART, RAIL, two_hands

SEEDS = st.integers(0, 2**32 - 1)


def walk(seed, n=3000, noise=5e-4):
    """Positions of a cart that goes to and fro, with noise."""
    random = np.random.default_rng(seed)
    time = 0.01 * np.arange(n)
    return np.sin(0.4 * time + random.uniform(0, 6)) + 0.3 * np.sin(1.3 * time) + noise * random.standard_normal(n)


def rail_log(x, step=0.01):
    return RunLog(step * np.arange(len(x)), np.column_stack([x, 0 * x, 0 * x]), None, {})


@given(SEEDS, st.floats(2e-4, 2e-2), st.floats(-1.0, 1.0))
def test_the_step_of_a_grid_is_found(seed, step, offset):
    column = offset + step * np.round(walk(seed, noise=0.0) / step)
    assert step_of(column) == pytest.approx(step, rel=1e-3)


@given(SEEDS, st.floats(3e-4, 2e-2))
def test_digits_that_are_cut_off_hide_no_grid(seed, step):
    """Printed to a twelfth of the step."""
    digit = step / 12
    column = digit * np.round(step * np.round(walk(seed, noise=0.0) / step) / digit)
    assert step_of(column) == pytest.approx(step, rel=0.05)


@given(SEEDS)
def test_numbers_have_no_grid(seed):
    assert step_of(walk(seed)) is None


@pytest.mark.parametrize(("step", "is_told"), [(5e-4, False), (1e-2, True)])
def test_coarse_steps_are_told_and_fine_ones_not(step, is_told):
    """5e-4 m beside noise of as much is no matter, a centimetre is."""
    told = quantised(rail_log(step * np.round(walk(1) / step)))
    assert bool(told) == is_told
    if told:
        assert told[0].factor == pytest.approx(step, rel=1e-3)
        assert f"{step / np.sqrt(12):.2g}" in told[0].words


@pytest.mark.parametrize("around", [0.0, np.pi])
@pytest.mark.parametrize("step", [0.01, 0.02])
def test_coarse_headings_are_told_wherever_they_are(step, around):
    """Beyond half a turn, too: a whole one is no number of steps, and a third of the step was told, or none."""
    log = rail_log(walk(1))
    heading = step * np.round(wrap_angle(around + walk(2)) / step)
    (told,) = quantised(replace(log, pose=np.column_stack([log.pose[:, :2], heading])))
    assert told.where == "heading"
    assert told.factor == pytest.approx(step, rel=1e-3)


@pytest.mark.parametrize("share", [0.1, 0.5])
def test_rows_written_again_are_told_and_left_out(share):
    log, random = two_hands(1), np.random.default_rng(7)
    again = random.random(len(log)) < share
    again[[0, -1]] = False
    rows = np.maximum.accumulate(np.where(again, 0, np.arange(len(log))))
    sensors = corrected_log(replace(log, pose=log.pose[rows]), CART)
    (told,) = sensors.suspicions
    assert (told.kind, told.where, told.put_right) == ("repeated", "pose", True)
    assert told.factor == pytest.approx(len(log) / (len(log) - again.sum()), rel=0.02)
    assert np.array_equal(np.isnan(sensors.log.pose).all(axis=1), again)


@given(SEEDS, st.floats(0.002, 0.02))
@settings(max_examples=10)
def test_a_coarse_sensor_repeats_itself_where_it_goes_slowly(seed, step):
    """That is no recorder's doing: 1.3 m/s, where fast, is a step or more a row."""
    told = corrected_log(rail_log(step * np.round(walk(seed, noise=0.0) / step)), RAIL).suspicions
    assert {one.kind for one in told} == {"quantised"}


@settings(max_examples=15)
@given(st.integers(0, 3), st.integers(3, 8))
def test_rows_put_in_between_are_told_and_left_out(seed, every):
    log = two_hands(seed)
    knots = np.arange(0, len(log), every)
    inside = np.arange(len(log)) <= knots[-1]
    pose = np.column_stack([np.interp(log.time, log.time[knots], column[knots]) for column in log.pose.T])
    right, (told,) = interpolated(replace(log, pose=np.where(inside[:, None], pose, log.pose)))
    assert told.factor == pytest.approx(every, rel=0.05)
    assert np.array_equal(right.pose[knots], log.pose[knots], equal_nan=True)
    assert np.isnan(right.pose[1 : every - 1]).all()
    assert right.velocity is log.velocity


def test_what_was_measured_is_left_as_it_is():
    log = two_hands(0)
    right, told = interpolated(log)
    assert right is log
    assert told == ()
    assert quantised(log) == slow(log) == ()


@pytest.mark.long
def test_a_clock_that_jumps_is_told_and_costs_nothing():
    """By a day, with the cart in between."""
    log = two_hands(3)
    late = replace(log, time=log.time + 86400.0 * (log.time > 12.0))
    (told,) = (one for one in check_sensors(late, CART) if one.kind == "holes")
    assert told.factor == pytest.approx(86400.0, abs=0.1)
    assert "12 s to 86412" in told.words
    seen, whole = look_at(late, CART).overview, look_at(log, CART).overview
    assert seen.travelled == pytest.approx(whole.travelled, rel=0.01)
    assert seen.sensors[0].gap == pytest.approx(86400.0, abs=0.1)
    assert not [one for one in check_sensors(log, CART) if one.kind == "holes"]


def test_a_heading_that_nobody_measured_is_told():
    """Unless the cart runs on a rail, or nothing moves."""
    still, moving = rail_log(0 * walk(0)), rail_log(walk(0))
    told = [one for one in corrected_log(moving, CART).suspicions if one.where == "heading"]
    assert [one.kind for one in told] == ["repeated"]
    assert "no_rotation" in told[0].words
    assert not [one for one in corrected_log(moving, RAIL).suspicions if one.where == "heading"]
    assert not [one for one in corrected_log(still, CART).suspicions if one.where == "heading"]
    blank = replace(still, pose=np.where(still.time[:, None] < 0.1, np.nan, still.pose))
    assert not [one for one in corrected_log(blank, CART).suspicions if one.where == "heading"]
    along_y = replace(moving, pose=moving.pose[:, [1, 0, 2]])
    assert [one.kind for one in corrected_log(along_y, CART).suspicions if one.where == "heading"] == ["repeated"]


def test_slow_rows_are_told():
    (told,) = slow(rail_log(walk(0), step=10.0))
    assert "milliseconds" in told.words
