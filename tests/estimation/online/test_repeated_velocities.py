"""Velocities that come again bit by bit: zeros that nobody filled in, a source that has frozen, a coarse sensor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp import Measurement
from estimation import CartFilter, DisturbedFilter
from estimation.online.repeated_velocities import CALIBRATION_VELOCITIES, RepeatedVelocities

from .test_repeated_poses import CART, VELOCITY, sample


def test_a_velocity_again_is_none_where_its_sensor_tells_its_noise():
    watch, random = RepeatedVelocities(), np.random.default_rng(0)
    for k in range(CALIBRATION_VELOCITIES):
        last = Measurement(0.01 * k, velocity=VELOCITY + 1e-4 * random.normal(size=3))
        assert watch.without_repeats(last) is last
    assert watch.without_repeats(replace(last, time=9.0)).velocity is None
    assert watch.without_repeats(Measurement(9.1, velocity=VELOCITY)).velocity is VELOCITY
    coarse = RepeatedVelocities()
    for k in range(2 * CALIBRATION_VELOCITIES):
        last = Measurement(0.01 * k, velocity=VELOCITY + 1e-2 * (k % 7 == 0))
        assert coarse.without_repeats(last) is last


@pytest.mark.parametrize("error", [0.0, 0.9, 1.1])
@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)])
def test_a_velocity_again_is_none_where_poses_have_gone_elsewhere(direction, error):
    """By 5 cm or 0.05 rad; across the wrap of headings, too. What is as it says is kept, as that of a coarse sensor."""
    watch, start, off = RepeatedVelocities(), np.array([0.0, 0.0, 3.1]), 0.05 * error * np.array(direction)
    for k in range(41):
        pose = start + 0.01 * k * VELOCITY + off * (k / 40)
        told = watch.without_repeats(Measurement(0.01 * k, pose, VELOCITY))
    assert (told.velocity is None) == (error > 1.0)
    assert told.pose is not None


@pytest.mark.parametrize("kind", [CartFilter, DisturbedFilter])
@pytest.mark.parametrize("what", ["zeros", "zeros from the start", "frozen"])
def test_a_velocity_that_nobody_fills_in_stops_no_cart(kind, what):
    """Controllers that believed it drove carts at 15 m/s, which poses told all the while."""
    learner, random, held, off = kind(CART, ["hand"]), np.random.default_rng(1), None, []
    for k in range(400):
        told = sample(0.01 * k, random)
        if k == 180:
            held = told.velocity
        if what == "zeros from the start" or (k >= 180 and what == "zeros"):
            told = replace(told, velocity=np.zeros(3))
        elif k >= 180:
            told = replace(told, velocity=held)
        found = learner.update(told)
        off.append(abs(found.motion.pose_sb[0] - sample(0.01 * k).pose[0]))
    assert max(off) < 0.15
    assert off[-1] < 0.01
    assert found.motion.velocity[0] == pytest.approx(0.5, abs=0.05)
