"""Poses that repeat the last one: left out where a recorder wrote them again, kept where a cart rests or a sensor can't
tell them apart."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs.run_log import ArmLog, RunLog
from cartgrasp.model import CartModel
from estimation.discrepancy.log_check import checked
from estimation.sensor_check.repeated_rows import without_repeats
from estimation.weak_form.balances import Balances
from tests.core.drawn import numbers

from ..runs import simulate

PERIOD, ROWS = 0.02, 200
TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
CART = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))


def log_of(pose, velocity=None):
    time = PERIOD * np.arange(len(pose))
    arms = {"arm": ArmLog(np.zeros((len(pose), 3)), np.zeros((len(pose), 6)))}
    return RunLog(time=time, pose=pose, velocity=velocity, arms=arms)


def moving(seed, noise=0.001):
    """At 0.5 m/s along a curve."""
    time = PERIOD * np.arange(ROWS)
    clean = np.column_stack([0.5 * time, 0.2 * np.sin(time), 0.4 * np.sin(time)])
    return clean + noise * np.random.default_rng(seed).standard_normal(clean.shape)


def repeated(rows, at):
    found = rows.copy()
    for i in sorted(at):
        found[i] = found[i - 1]
    return found


@given(seed=st.integers(0, 99), at=st.sets(st.integers(1, ROWS - 2), max_size=20), speed=st.booleans())
def test_what_a_recorder_wrote_again_is_missing(seed, at, speed):
    at = {i for i in at if not set(range(i - 10, i)) <= at}
    rows = repeated(moving(seed), at)
    log = without_repeats(log_of(rows, rows if speed else None))
    for found in (log.pose, *([log.velocity] if speed else [])):
        assert set(np.flatnonzero(np.isnan(found).any(axis=1))) == at
        np.testing.assert_array_equal(np.delete(found, list(at), axis=0), np.delete(rows, list(at), axis=0))


@given(rest=st.integers(15, 60), seed=st.integers(0, 99))
def test_a_cart_that_rests_is_seen_to_rest(rest, seed):
    rows = moving(seed, 0.0)
    still = np.concatenate([rows[:50], np.repeat(rows[50:51], rest, axis=0), rows[51:]])
    np.testing.assert_array_equal(without_repeats(log_of(still)).pose, still)


@given(resolution=numbers(0.001, 0.02), speed=numbers(0.01, 0.04))
def test_what_a_sensor_cannot_tell_apart_is_kept(resolution, speed):
    """A cart that crosses a step of an encoder in more than a row."""
    way = np.round(speed * PERIOD * np.arange(ROWS) / resolution) * resolution
    rows = np.column_stack([way, np.zeros((ROWS, 2))])
    np.testing.assert_array_equal(without_repeats(log_of(rows)).pose, rows)


def test_what_is_missing_stays_missing():
    rows = moving(3)
    rows[[20, 21, 60]] = np.nan
    rows[22] = rows[19]
    found = without_repeats(log_of(rows)).pose
    assert np.flatnonzero(np.isnan(found).any(axis=1)).tolist() == [20, 21, 22, 60]


@pytest.mark.long
def test_the_check_counts_them_and_reads_the_noise_of_the_others():
    """Two poses of three are written again, as of a camera at 33 Hz."""
    log, _ = simulate(TRUTH, 3, 30.0, noise=(0.001, 0.002, 1.0))
    held = replace(log, pose=log.pose[np.arange(len(log)) // 3 * 3])
    whole, twice = (checked(each, CART, Balances.of(without_repeats(each), CART)) for each in (log, held))
    assert whole.stale_poses == 0
    assert twice.stale_poses == pytest.approx(2 / 3 * len(log), abs=80)  # but those at rest
    assert twice.noise.position == pytest.approx(whole.noise.position, rel=0.25)
    assert twice.distance == pytest.approx(whole.distance, rel=0.02)


@given(
    seed=st.integers(0, 99),
    step=numbers(0.0005, 0.002),
    every=st.integers(2, 4),
    into=numbers(0.0, 1.0),
    mean=st.booleans(),
)
@example(seed=38, step=0.0003, every=3, into=0.0, mean=True)
def test_an_encoder_that_rests_is_seen_between_its_steps_too(seed, step, every, into, mean):
    """Resampled or averaged values of an encoder lie anywhere between its steps, which are its resolution still, where
    they are several times its noise."""
    fine = PERIOD / every * np.arange(ROWS * every)
    way = 0.3 * np.maximum(fine - 1.0, 0.0) ** 2 + 1e-4 * np.random.default_rng(seed).standard_normal(len(fine))
    way = np.round(way / step) * step
    at = (np.arange(ROWS - 1) + into) * every
    coarse = (
        way[: ROWS * every].reshape(ROWS, every).mean(axis=1)[:-1] if mean else np.interp(at, np.arange(len(way)), way)
    )
    rows = np.column_stack([coarse, np.zeros((ROWS - 1, 2))])
    assert np.isnan(without_repeats(log_of(rows)).pose[:, 0]).sum() <= 2  # where it starts, it may repeat and then leap
