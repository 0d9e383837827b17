"""Absurd samples are left out; whatever a cart or a hand can do is not."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.logs import RunLog
from cartgrasp.logs.run_log import ArmLog
from estimation.log_noise.glitches import without_glitches

TIME = np.arange(0.0, 4.0, 0.01)


def log_of(force, pose=None, noise=1.0):
    generator = np.random.default_rng(3)
    wrench = noise * generator.standard_normal((len(TIME), 6))
    wrench[:, 0] += force
    turning = np.column_stack([np.sin(TIME), TIME, 3.0 + TIME]) if pose is None else pose
    turning[:, 2] = (turning[:, 2] + np.pi) % (2 * np.pi) - np.pi
    return RunLog(TIME, turning, None, {"arm": ArmLog(np.zeros((len(TIME), 3)), wrench)})


@settings(max_examples=25, deadline=None)
@given(st.integers(5, 390), st.integers(1, 3), st.floats(60.0, 1e9))
def test_a_spike_is_left_out_alone(row, rows, size):
    force = np.where((np.arange(len(TIME)) >= row) & (np.arange(len(TIME)) < row + rows), size, 0.0)
    found = without_glitches(log_of(force))
    missing = np.flatnonzero(np.isnan(found.arms["arm"].wrench).any(axis=1))
    assert missing.tolist() == list(range(row, row + rows))
    assert np.isfinite(found.pose).all()


@settings(max_examples=25, deadline=None)
@given(st.integers(10, 390), st.integers(6, 100), st.floats(-1e3, 1e3), st.floats(0.0, 3.0))
def test_what_lasts_is_kept(row, rows, size, noise):
    force = np.where((np.arange(len(TIME)) >= row) & (np.arange(len(TIME)) < row + rows), size, 0.0)
    log = log_of(force, noise=noise)
    found = without_glitches(log)
    assert np.array_equal(found.table, log.table)


def test_a_pose_that_jumps_for_a_moment_is_left_out():
    pose = np.column_stack([np.sin(TIME), TIME, 3.0 + TIME])
    pose[200:202, 1] += 0.4
    found = without_glitches(log_of(0.0, pose))
    assert np.flatnonzero(np.isnan(found.pose).any(axis=1)).tolist() == [200, 201]


def test_what_happens_often_is_no_accident():
    force = np.where(np.arange(len(TIME)) % 20 == 0, 500.0, 0.0)
    assert np.isfinite(without_glitches(log_of(force)).table).all()
