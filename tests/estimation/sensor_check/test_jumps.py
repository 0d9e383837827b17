"""Trackers that lose the cart and find it elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.logs import ArmLog, RunLog
from estimation.sensor_check import check_sensors
from estimation.sensor_check.jumps import jump_times, jumps
from estimation.weak_form.log_segments import segment_logs
from estimation.whole_log.identification import identify

from .logs import CART, cart_of, found, sealed, two_hands


@pytest.mark.parametrize(("where", "by"), [("pose", (0.05, 0, 0)), ("pose", (0, -2, 0)), ("heading", (0, 0, 0.2))])
def test_a_jump_is_told_with_its_size_and_time(where, by):
    log = two_hands(0)
    moved = replace(log, pose=log.pose + np.outer(log.time > 17.0, by))
    (told,) = jumps(moved)
    assert (told.kind, told.where) == ("jumps", where)
    assert told.factor == pytest.approx(np.linalg.norm(by), rel=0.2)
    assert "once" in told.words
    assert "at t = 17" in told.words
    assert ("jumps", where) in found(check_sensors(moved, CART))


@settings(max_examples=10)
@given(seed=st.integers(0, 3), by=st.floats(0.02, 0.1), way=st.floats(-np.pi, np.pi), rate=st.sampled_from([1, 2, 3]))
def test_small_jumps_are_found(seed, by, way, rate):
    """Of ten times the noise and more, of poses at 100, 50 and 33 Hz: the log is taken apart there."""
    log = two_hands(seed)
    rows = np.arange(0, len(log), rate)
    noise = 0.002 * np.random.default_rng(seed).standard_normal((len(rows), 3))
    pose = log.pose[rows] + noise + np.outer(log.time[rows] > 17.0, (by * np.cos(way), by * np.sin(way), 0.0))
    moved = replace(
        log, time=log.time[rows], pose=pose, velocity=None,
        arms={name: ArmLog(arm.contact[rows], arm.wrench[rows]) for name, arm in log.arms.items()},
    )  # fmt: skip
    if by > 1.2 * rate * 0.01:
        (time,) = jump_times(moved)
        assert 17.0 < time < 17.0 + 0.011 * rate
        assert len(segment_logs(moved, (), [time])) == 2


def test_jumps_teach_nothing():
    """Before, a mass of 24 kg was told as 13.5 ± 1.7 kg, and loads that slosh, pushes and payloads were named."""
    log, random = two_hands(2), np.random.default_rng(5)
    pose = log.pose + 0.002 * random.standard_normal(log.pose.shape)
    for time in (8.0, 16.0, 25.0, 33.0):
        pose = pose + np.outer(log.time > time, (*random.choice([-0.04, 0.04], 2), 0.0))
    moved = replace(log, pose=pose, velocity=None)
    assert len(jump_times(moved)) == 4
    mass = identify([moved], cart_of(0.7)).parameters["mass"]
    assert abs(mass.value - 24.0) < 4.0 * mass.std < 4.0


@pytest.mark.long
def test_what_is_no_jump():
    """A cart that is stopped by a wall, coarse steps, rows that repeat, rows that are lost, and single wild rows."""
    log = two_hands(0)
    at = np.minimum(log.time, 17.0)
    stopped = np.column_stack([0.8 * at, 0 * at, 0 * at])
    rows = np.arange(len(log))
    assert jumps(replace(log, pose=stopped + np.random.default_rng(0).normal(0, 5e-4, stopped.shape))) == ()
    assert jumps(replace(log, pose=np.round(log.pose / 0.01) * 0.01)) == ()
    assert jumps(replace(log, pose=log.pose[rows // 3 * 3])) == ()
    lost = np.where((rows % 50 < 20)[:, None], np.nan, log.pose)
    assert jumps(replace(log, pose=lost)) == ()
    for seed in range(3):
        assert jumps(sealed("nothing", seed)[0]) == ()


@pytest.mark.parametrize("rate", [100, 500, 1000])
@pytest.mark.parametrize("which", [0, 2])
def test_coarse_steps_are_no_jumps(rate, which):
    """In a cart that rests, or goes straight, the next step of a coarse sensor was called a jump."""
    time = np.arange(0.0, 40.0, 1.0 / rate)
    pose = np.column_stack([2.0 - 2.0 * np.cos(0.5 * time), 0.0 * time, 0.0 * time])
    pose[:, which] = 0.01 * np.round(0.31 + 0.9 * np.sin(0.11 * time))
    assert jumps(RunLog(time, pose, None, {})) == ()


def test_a_jump_is_no_way_that_the_cart_went():
    """Before, theta was told to be in degrees, or the frame to be turned, surely."""
    log, cart = sealed("nothing", 1)
    moved = replace(log, pose=log.pose + np.outer(log.time > 30.0, (5.0, 2.0, 0.0)))
    assert found(check_sensors(moved, cart)).keys() == {("jumps", "pose")}
