"""Poses that come in steps, against the motion before it was rounded."""

import math
from dataclasses import replace

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from cartgrasp.logs import RunLog
from estimation.weak_form.quantisation import dequantised

TIME = np.arange(0.0, 20.0, 0.002)


def swinging(amplitude, frequency, heading=0.0):
    pose = np.zeros((len(TIME), 3))
    pose[:, 0] = amplitude * np.sin(2 * np.pi * frequency * TIME)
    pose[:, 2] = heading * np.sin(2 * np.pi * frequency * TIME)
    return RunLog(TIME, pose, None, {})


def rounded(log, step):
    return replace(log, pose=step * np.round(log.pose / step))


@given(st.floats(0.05, 0.3), st.floats(0.1, 0.5), st.floats(0.001, 0.01))
def test_what_was_rounded_is_found_no_worse_than_it_was_recorded(amplitude, frequency, step):
    """Where a motion turns within a step, nobody knows how far it went."""
    true = swinging(amplitude, frequency)
    coarse = rounded(true, step)
    rms = [np.sqrt(np.mean((log.pose - true.pose)[:, 0] ** 2)) for log in (dequantised(coarse), coarse)]
    assert rms[0] < 1.05 * rms[1]


@given(st.floats(0.02, 2.0), st.floats(0.001, 0.01))
@example(1.0, 0.00465457065665074)
def test_an_even_motion_is_found_to_what_it_goes_in_a_sample(speed, step):
    pose = np.zeros((len(TIME), 3))
    pose[:, 0] = speed * TIME
    found = dequantised(rounded(RunLog(TIME, pose, None, {}), step)).pose
    unknown = math.ceil(step / speed / TIME[1])  # samples before the first step, or after the last, at most
    inside = slice(unknown, -unknown)
    assert np.abs(found - pose)[inside, 0].max() < speed * TIME[1] + 1e-9


@given(st.floats(0.0, 0.01), st.integers(0, 5))
def test_no_reading_is_left_by_more_than_half_a_step(noise, seed):
    log = swinging(0.2, 0.2, heading=3.0)
    shaken = log.pose + noise * np.random.default_rng(seed).standard_normal(log.pose.shape)
    coarse = rounded(replace(log, pose=shaken), 0.005)
    away = dequantised(coarse).pose - coarse.pose
    assert np.abs((away + np.pi) % (2 * np.pi) - np.pi).max() <= 0.0025 + 1e-9


def test_fine_poses_and_poses_that_are_held_stay():
    log = swinging(0.2, 0.2)
    held = replace(log, pose=log.pose[np.arange(len(TIME)) // 5 * 5])
    assert np.abs(dequantised(log).pose - log.pose).max() < 1e-6
    assert np.array_equal(dequantised(held).pose, held.pose)
