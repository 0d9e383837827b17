"""Rows written again, steps of encoders, jumps and gaps: told where they are, and not where they aren't."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.logs import ArmLog, RunLog
from estimation.log_noise import noise_floor
from estimation.sensor_check.recorder.gaps import holes
from estimation.sensor_check.recorder.jumps import jumps, jumps_of, without_jumps
from estimation.sensor_check.recorder.repeats import repeated, repeats, straight_rows, without_repeats
from estimation.sensor_check.recorder.steps import noise_with_steps, quantised, step_of

from .sensor_logs import found, sealed, two_hands

SEEDS = st.integers(0, 2**32 - 1)


def walk(seed, n=3000, noise=5e-4):
    """Positions of a cart that goes to and fro, with noise."""
    random = np.random.default_rng(seed)
    time = 0.01 * np.arange(n)
    return np.sin(0.4 * time + random.uniform(0, 6)) + 0.3 * np.sin(1.3 * time) + noise * random.standard_normal(n)


def rail_log(x, time=None):
    time = 0.01 * np.arange(len(x)) if time is None else time
    nothing = np.zeros((len(x), 3))
    pose = np.column_stack([x, 0 * x, 0 * x])
    return RunLog(time, pose, None, {"arm": ArmLog(nothing, np.zeros((len(x), 6)))})


# --- steps --------------------------------------------------------------------------------------------------


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
    assert step_of(np.random.default_rng(seed).standard_normal(300)) is None


@given(SEEDS, st.floats(1e-3, 5e-3))
def test_rounding_makes_the_noise_that_is_said(seed, step):
    """Of a cart that moves by many steps: what rounding really adds, to a sixth, as a cart that turns round keeps to
    the same step for long; fewer rows than show a grid leave what differences tell."""
    exact = walk(seed, noise=0.0)
    column = step * np.round(exact / step)
    assert noise_with_steps(column) == pytest.approx((column - exact).std(), rel=0.17)
    assert noise_with_steps(column[:5]) == noise_floor(column[:5])


def test_differences_of_slow_steps_tell_no_noise():
    """A centimetre under a cart that creeps: neighbours are equal, third differences mostly 0."""
    column = 0.01 * np.round(np.sin(0.05 * np.arange(3000) * 0.01) * 50 / 0.01 / 50)
    assert noise_floor(column) == 0.0
    assert noise_with_steps(column) == pytest.approx(0.01 / np.sqrt(12))


@pytest.mark.parametrize(("step", "is_told"), [(5e-4, False), (1e-2, True)])
def test_coarse_steps_are_told_and_fine_ones_not(step, is_told):
    """5e-4 m beside noise of as much is no matter, a centimetre is."""
    column = step * np.round(walk(1) / step)
    told = quantised(rail_log(column))
    assert bool(told) == is_told
    if told:
        assert told[0].where == "pose"
        assert told[0].factor == pytest.approx(step, rel=1e-3)
        assert f"{step / np.sqrt(12):.2g}" in told[0].words


def test_an_encoder_of_half_a_millimetre_without_other_noise_is_told():
    told = quantised(rail_log(5e-4 * np.round(walk(2, noise=0.0) / 5e-4)))
    assert told[0].factor == pytest.approx(5e-4, rel=1e-3)


# --- repeats ------------------------------------------------------------------------------------------------


@settings(max_examples=25)
@given(st.integers(0, 3), st.floats(0.01, 0.5), SEEDS)
def test_rows_written_again_are_found(seed, share, draw):
    """Every one of them but those at the ends, and no other."""
    log, random = two_hands(seed), np.random.default_rng(draw)
    again = random.random(len(log)) < share
    again[0] = again[-1] = False
    rows = np.arange(len(log))
    rows[again] = 0
    rows = np.maximum.accumulate(rows)
    written = replace(log, pose=log.pose[rows])
    assert np.array_equal(repeats(written.pose, log.time).row, again & (np.diff(rows, prepend=-1) == 0))
    told = [one for one in repeated(written) if one.where == "pose"]
    assert len(told) == 1
    assert told[0].probability > 0.9
    assert told[0].factor == pytest.approx(len(log) / (len(log) - again.sum()))
    fresh = without_repeats(written)
    assert np.array_equal(np.isnan(fresh.pose).all(axis=1), again)
    assert np.array_equal(fresh.velocity, log.velocity)


@settings(max_examples=20)
@given(st.integers(0, 3), st.integers(3, 8))
def test_rows_put_in_between_are_found(seed, every):
    log = two_hands(seed)
    n = (len(log) - 1) // every * every + 1
    knots = np.arange(0, n, every)
    pose = np.column_stack([np.interp(log.time[:n], log.time[knots], column[knots]) for column in log.pose.T])
    between = replace(
        log,
        time=log.time[:n],
        pose=pose,
        velocity=None,
        arms={k: ArmLog(a.contact[:n], a.wrench[:n]) for k, a in log.arms.items()},
    )
    straight = straight_rows(pose, log.time[:n])
    assert not straight[knots].any()
    assert straight.sum() > 0.95 * (n - len(knots))
    told = [one for one in repeated(between) if "straight lines" in one.words]
    assert [one.where for one in told] == ["pose"]
    assert told[0].factor == pytest.approx(every, rel=0.1)


def test_encoders_that_stand_or_creep_repeat_nothing():
    """A grid's rows are equal while the cart rests, and one step apart while it creeps."""
    time = 0.01 * np.arange(3000)
    for slow in (0.0, 0.02, 0.15):
        x = 1e-3 * np.round((slow * time + 0.2 * np.sin(0.3 * time)) / 1e-3)
        assert repeated(rail_log(x)) == ()


def test_smooth_motion_without_noise_is_not_interpolated():
    time = 0.01 * np.arange(3000)
    x = np.where(time % 6 < 3, 0.4 * time, 1.0 + 0.1 * np.sin(time))
    assert not straight_rows(rail_log(np.round(x, 7)).pose, time).any()


# --- jumps --------------------------------------------------------------------------------------------------


@settings(max_examples=40)
@given(SEEDS, st.integers(20, 2970), st.integers(1, 3), st.floats(0.02, 3.0), st.booleans())
def test_rows_that_are_off_are_left_out_alone(seed, first, rows, size, down):
    column = walk(seed)
    column[first : first + rows] += -size if down else size
    log = rail_log(column)
    told = jumps(log)
    assert [one.where for one in told] == ["pose"]
    assert told[0].factor == pytest.approx(size, rel=0.25)
    assert f"{log.time[first]:.2f} s" in told[0].words
    missing = np.flatnonzero(np.isnan(without_jumps(log).pose[:, 0]))
    assert missing.tolist() == list(range(first, first + rows))


@settings(max_examples=40)
@given(SEEDS, st.integers(20, 2970), st.floats(0.05, 3.0))
def test_a_shift_that_stays_is_told_and_kept(seed, first, size):
    column = walk(seed)
    column[first:] += size
    told = jumps(rail_log(column))
    assert [one.where for one in told] == ["pose"]
    assert "stays" in told[0].words
    assert told[0].factor == pytest.approx(size, rel=0.1)
    assert np.flatnonzero(jumps_of(column, 0.01 * np.arange(3000)).shift).tolist() == [first]


@given(SEEDS, st.floats(0.3, 2.0))
def test_a_bounce_is_no_jump(seed, speed):
    """At a bumper the speed turns round from one row to the next; places don't jump."""
    time = 0.01 * np.arange(2000)
    random = np.random.default_rng(seed)
    x = -speed * np.abs((time % 4.0) - 2.0) + 5e-4 * random.standard_normal(len(time))
    assert jumps(rail_log(x)) == ()


@pytest.mark.parametrize("seed", range(6))
def test_poses_that_the_rough_generator_puts_off(seed):
    log, _ = sealed("nothing", seed, is_rough=True)
    smooth, _ = sealed("nothing", seed)
    told = {one.where for one in jumps(log)}
    assert told <= {"pose"}
    assert jumps(smooth) == ()


# --- gaps ---------------------------------------------------------------------------------------------------


def some_rows(log, kept):
    arms = {name: ArmLog(arm.contact[kept], arm.wrench[kept]) for name, arm in log.arms.items()}
    return replace(log, time=log.time[kept], pose=log.pose[kept], velocity=None, arms=arms)


@given(st.integers(10, 2900), st.integers(1, 90))
def test_lost_rows_are_counted(first, rows):
    kept = np.ones(3000, dtype=bool)
    kept[first : first + rows] = False
    told = holes(some_rows(rail_log(walk(0)), kept))
    assert [one.where for one in told] == ["time"]
    assert told[0].factor == pytest.approx(0.01 * (rows + 1))
    assert told[0].words.startswith(f"{rows} rows are missing")


@pytest.mark.parametrize("rate", [1.0, 2.0, 4.0])
def test_a_slow_log_has_no_holes_and_is_said_to_be_slow(rate):
    time = np.arange(120) / rate
    told = holes(rail_log(np.sin(time), time))
    assert len(told) == 1
    assert "no holes" in told[0].words
    assert "slow" in told[0].words
    assert told[0].factor == pytest.approx(1 / rate)


@pytest.mark.parametrize("rate", [20.0, 100.0, 1000.0])
def test_an_even_log_is_fine_even_if_its_clock_jitters(rate):
    random = np.random.default_rng(0)
    time = (np.arange(2000) + random.uniform(-0.2, 0.2, 2000)) / rate
    assert holes(rail_log(np.sin(time), time)) == ()


def test_a_sensor_that_is_blank_for_a_while_has_a_hole():
    log = two_hands(0)
    pose = log.pose.copy()
    pose[1000:1100] = np.nan
    told = holes(replace(log, pose=pose))
    assert [one.where for one in told] == ["pose"]
    assert told[0].factor == pytest.approx(1.01)


def test_a_sensor_of_a_lower_rate_has_none():
    log = two_hands(0)
    pose = np.where((np.arange(len(log)) % 4 == 0)[:, None], log.pose, np.nan)
    assert holes(replace(log, pose=pose)) == ()


def test_a_sound_log_says_nothing_of_its_recorder():
    log = two_hands(0)
    assert found((*repeated(log), *quantised(log), *jumps(log), *holes(log))) == {}
