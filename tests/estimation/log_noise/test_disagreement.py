"""Velocities that are late or scaled, beside poses: what a filter may believe of them."""

from __future__ import annotations

import numpy as np
import pytest

from estimation.log_noise.log_noise import COMPARED_SPAN, velocity_noise

PLACE, VELOCITY, STEP = 0.0005, 0.005, 0.01


def record(seed, late=0.0, scale=1.0, duration=30.0):
    """Of a cart that goes to and fro, with both sensors' noise."""
    random, time = np.random.default_rng(seed), np.arange(0.0, duration, STEP)
    place = 0.8 * np.sin(time) + PLACE * random.standard_normal(len(time))
    velocity = scale * 0.8 * np.cos(time - late) + VELOCITY * random.standard_normal(len(time))
    return time, place, velocity


@pytest.mark.parametrize("seed", range(40))
def test_sensors_that_agree_are_as_quiet_as_they_are(seed):
    assert velocity_noise(*record(seed), (PLACE, VELOCITY)) == VELOCITY


@pytest.mark.parametrize("wrong", [{"late": 0.05}, {"scale": 1.05}, {"scale": -1.0}])
def test_one_that_tells_another_motion_is_as_noisy_as_the_ways_are_apart(wrong):
    """By the largest tenth of sines, which is that of normal numbers 0.85 times as large as their amplitude."""
    time, place, velocity = record(1, **wrong)
    off = 0.8 * COMPARED_SPAN * (0.05 if "late" in wrong else abs(wrong["scale"] - 1.0))
    expected = 0.6 * off / np.sqrt(STEP * COMPARED_SPAN)
    assert velocity_noise(time, place, velocity, (PLACE, VELOCITY)) == pytest.approx(expected, rel=0.12)


def test_glitches_and_holes_are_no_disagreement():
    time, place, velocity = record(2)
    place[::701] += 5.0
    velocity[300:420] = np.nan
    assert velocity_noise(time, place, velocity, (PLACE, VELOCITY)) == VELOCITY


def test_a_short_log_tells_nothing():
    assert velocity_noise(*record(3, scale=2.0, duration=5.0), (PLACE, VELOCITY)) == VELOCITY
    nothing = np.full(3, np.nan)
    assert velocity_noise(nothing, nothing, nothing, (PLACE, VELOCITY)) == VELOCITY
