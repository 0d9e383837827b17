"""Poses that come again bit by bit: a frozen tracker, a recorder that holds the last one, a cart that rests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp import CartModel, Inertia, Measurement
from cartgrasp.effects import ViscousDrag
from cartgrasp.motion import Motion
from estimation import CartFilter, DisturbedFilter
from estimation.online.repeated_poses import REST_CALIBRATION_POSES, RepeatedPoses

CART = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(5.0, 2.0),))
FAST, REST = (Motion(np.zeros(3), np.array([u, 0.0])) for u in (0.4, 0.0))
POSE, VELOCITY = np.array([1.0, 2.0, 0.3]), np.array([0.4, 0.1, 0.0])


def sample(time, random=None, pose=0.0005, velocity=0.005):
    """Of a cart that rests for a second, and then goes straight on with 0.5 m/s² to 0.5 m/s."""
    off = np.zeros(6) if random is None else random.normal(size=6)
    since, full = max(time - 1.0, 0.0), max(time - 2.0, 0.0)
    rate, speed = 0.5 * (1.0 < time < 2.0), min(0.5 * since, 0.5)
    x = 0.25 * (since - full) ** 2 + 0.5 * full
    felt = np.array([24.0 * rate + 5.0 * speed, 0.0, 0.0, 0.0, 0.0, 0.0])
    seen = np.array([x, 0.0, 0.0]) + pose * off[:3], np.array([speed, 0.0, 0.0]) + velocity * off[3:]
    return Measurement(time, *seen, {"hand": felt}, {"hand": np.array([-0.25, 0.0, 1.0])})


@pytest.mark.parametrize("motion", [FAST, REST])
@pytest.mark.parametrize("is_same", [True, False], ids=["all of it", "pose alone"])
def test_a_pose_again_is_none_where_the_cart_moves(motion, is_same):
    watch = RepeatedPoses()
    watch.without_repeats(Measurement(0.0, POSE, VELOCITY), motion)
    again = Measurement(0.01, POSE.copy(), VELOCITY if is_same else 1.01 * VELOCITY)
    told = watch.without_repeats(again, motion)
    if motion is REST:
        assert told is again
    else:
        assert told.pose is None
        assert (told.velocity is None) == is_same
    assert watch.without_repeats(Measurement(0.02, 1.01 * POSE, VELOCITY), motion).pose is not None


def test_a_sensor_that_tells_its_noise_at_rest_never_repeats_itself():
    watch, random = RepeatedPoses(), np.random.default_rng(0)
    for k in range(REST_CALIBRATION_POSES):
        last = Measurement(0.01 * k, POSE + 1e-4 * random.normal(size=3))
        assert watch.without_repeats(last, REST) is last
    assert watch.without_repeats(replace(last, time=9.0), REST).pose is None
    coarse = RepeatedPoses()
    for k in range(2 * REST_CALIBRATION_POSES):
        last = Measurement(0.01 * k, POSE + 1e-3 * (k % 7 == 0))
        assert coarse.without_repeats(last, REST) is last


@pytest.mark.parametrize("kind", [CartFilter, DisturbedFilter])
@pytest.mark.parametrize("what", ["pose and velocity", "pose", "pose, without velocities"])
def test_a_frozen_tracker_is_not_believed(kind, what):
    """0.5 s later it is stale; until then the cart goes on as the wrenches say. Before, health was `ok` or `outliers`,
    and the cart was believed to stand, or to be held."""
    made, random, last = kind(CART, ["hand"]), np.random.default_rng(1), sample(0.0)
    for k in range(400):
        told = now = sample(0.01 * k, random)
        last = last if k >= 300 else now
        if k >= 300:
            told = replace(now, pose=last.pose, velocity=last.velocity if what == "pose and velocity" else now.velocity)
        estimate = made.update(replace(told, velocity=None) if what.endswith("velocities") else told)
        if 300 < k < 345:
            assert estimate.health == "ok"
        if k >= 375:
            assert estimate.health == "stale"
    assert abs(estimate.motion.pose_sb[0] - now.pose[0]) < 0.1
    assert abs(estimate.motion.velocity[0] - 0.5) < 0.1


def test_what_rests_without_noise_is_seen():
    made = CartFilter(CART, ["hand"])
    assert {str(made.update(sample(0.001 * k)).health) for k in range(1000)} == {"ok"}


def test_poses_that_are_held_teach_what_new_ones_do():
    """30 poses a second, in samples of 100 Hz: the last one again and again, or none."""
    found = []
    for is_held in (True, False):
        made, random = CartFilter(CART, ["hand"]), np.random.default_rng(2)
        for k in range(600):
            now = sample(0.01 * k, random)
            if k % 3 == 0:
                last = now
            missing = {"pose": last.pose, "velocity": last.velocity} if is_held else {"pose": None, "velocity": None}
            estimate = made.update(now if k % 3 == 0 else replace(now, **missing))
        found.append(estimate.parameters["mass"])
    assert found[0].value == pytest.approx(found[1].value, abs=0.3 * found[1].std)
    assert abs(found[0].value - 24.0) < 3.0 * found[0].std
