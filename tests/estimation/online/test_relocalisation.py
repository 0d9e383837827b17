"""A belief that a push from outside left behind is given up for poses that agree; outliers tear it no more for that."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.effects import RollingResistance, ViscousDrag
from cartgrasp.first_guess import FirstGuess
from cartgrasp.frames import body_to_world
from cartgrasp.simulation import ModelPlant
from cartgrasp.wheels import Wheel
from estimation import CartFilter, DisturbedFilter, FilterNoise, RegressorEstimator

from ..runs import simulate_two_hands

NOISE = FilterNoise(position=0.001, heading=0.001, linear_velocity=0.01, yaw_rate=0.01, force=2.0, moment=0.08)
DEVIATIONS = np.array([2.0, 2.0, 2.0, 0.08, 0.08, 0.08])
CORNERS = tuple(Wheel("caster", x, y, 0.05) for x in (-0.9, 0.9) for y in (-0.4, 0.4))
STD = FirstGuess((("mass", 15.0), ("com_x", 0.1), ("com_y", 0.03), ("inertia", 15.0)))
EFFECTS = ViscousDrag(5.0, 3.0), RollingResistance(0.01)
BED = cg.CartModel(cg.Inertia(80.0, (0.0, 0.0), 30.0), cg.RollingConstraints(None), EFFECTS, CORNERS, first_guess=STD)
TROLLEY = cg.CartModel(cg.Inertia(24.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(3.0, 1.2),))
HAND, STEP = np.array([-0.25, 0.0, 0.95]), 0.002
PUSHED = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
FIRST = cg.CartModel(cg.Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(2.0, 1.0),))
LEARNING = FilterNoise(force=1.0, moment=0.05)


def driven(cart, duration, push=None, spoiled=None, has_velocity=False):
    """Errors of the position (n,), m, and healths, every 10 ms: wrenches come every 2 ms, poses every 34 ms. `push`
    acts from 5 to 6.5 s beside the hand, and what is seen from 1 s on may be `spoiled`."""
    learner, plant, random = CartFilter(cart, ["hand"], noise=NOISE), ModelPlant(cart), np.random.default_rng(0)
    errors, healths = [], []
    for k in range(round(duration / STEP)):
        time, motion = STEP * k, plant.motion
        wrench = np.array([10.0 * np.sin(1.5 * time) + 6.0, 0.0, 0.0, 0.0, 0.0, 0.5 * np.sin(1.1 * time)])
        pose = velocity = None
        if k % 17 == 0:
            pose = motion.pose_sb + 1e-3 * random.normal(size=3)
            pose = spoiled(time, pose, random) if spoiled is not None and time >= 1.0 else pose
        if has_velocity and k % 5 == 0:
            velocity = body_to_world(motion.pose_sb[2]) @ cart.basis_b @ motion.velocity + 0.01 * random.normal(size=3)
        if pose is not None or velocity is not None:
            learner.update(cg.Measurement(time, pose, velocity))
        felt = {"hand": wrench + DEVIATIONS * random.normal(size=6)}
        told = learner.update(cg.Measurement(time, wrenches=felt, contacts={"hand": HAND}))
        if k % 5 == 0:
            errors.append(float(np.hypot(*(told.motion.pose_sb - motion.pose_sb)[:2])))
            healths.append(told.health)
        beside = push if push is not None and 5.0 <= time < 6.5 else np.zeros(6)
        plant.step(cg.ContactWrenches({"hand": wrench, "push": beside}, {"hand": HAND, "push": np.zeros(3)}), STEP)
    return np.array(errors), healths


@pytest.mark.some(1)
@pytest.mark.parametrize("has_velocity", [False, True])
def test_a_push_from_outside_leaves_no_belief_behind(has_velocity):
    """It was metres off, and for ten seconds, on casters alone."""
    errors, healths = driven(BED, 8.0, np.array([20.0, 60.0, 0.0, 0.0, 0.0, 5.0]), has_velocity=has_velocity)
    assert errors.max() < 0.04
    assert errors[700:].max() < 0.015
    assert "outliers" in healths


def test_an_offset_for_good_is_believed():
    errors, _ = driven(TROLLEY, 3.0, spoiled=lambda time, pose, random: pose + np.array([0.2, -0.1, 0.0]))
    np.testing.assert_allclose(errors[150:], np.hypot(0.2, 0.1), atol=0.02)


def jumping(time, pose, random):
    return pose + random.normal(0.0, 1.0, 3) * (random.random() < 0.3)


def test_outliers_that_jump_are_not():
    """Three of ten poses are anywhere within a metre or so."""
    assert driven(TROLLEY, 4.0, spoiled=jumping)[0].max() < 0.05


def test_a_pose_that_is_repeated_to_the_last_digit_is_not():
    elsewhere = []

    def stuck(time, pose, random):
        elsewhere.append(pose + np.array([1.0, 0.0, 0.0]))
        return elsewhere[0]

    assert driven(TROLLEY, 1.3, spoiled=stuck)[0].max() < 0.5


def test_poses_that_go_elsewhere_than_measured_velocities_are_not():
    """They run away at 0.4 m/s, which velocities don't say."""
    errors, healths = driven(
        TROLLEY,
        3.0,
        spoiled=lambda time, pose, random: pose + np.array([0.4 * (time - 1.0), 0.0, 0.0]),
        has_velocity=True,
    )
    assert errors[-1] < 0.25
    assert healths[-1] == "outliers"


@pytest.mark.some(3)
@pytest.mark.parametrize("kind", [CartFilter, DisturbedFilter, RegressorEstimator])
@pytest.mark.parametrize("turned_by", [0.0, 0.5])
def test_parameters_are_learned_beyond_a_new_origin(kind, turned_by):
    """A tracker that was started again tells other places, at times other directions, for good. Nothing more was ever
    learned, no load and no reversed sensor seen, with health ok; a regressor told the old place for 25 s."""
    made, found = kind(FIRST, ["left", "right"], noise=LEARNING), []
    cosine, sine = np.cos(turned_by), np.sin(turned_by)
    turn = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    for m in simulate_two_hands(PUSHED, 4, duration=16.0, noise=(0.0005, 0.005, 1.0)).measurements():
        if m.time >= 5.0:
            m = replace(m, pose=turn @ m.pose + [2.0, 1.0, turned_by], velocity=turn @ m.velocity)
        found.append(made.update(m))
        if m.time > 9.0:
            assert np.linalg.norm(found[-1].motion.pose_sb - m.pose) < 0.01
    before, later = (
        [one for one in found if start <= one.time < end and one.health == "ok"] for start, end in ((4.5, 5.0), (9, 16))
    )
    assert len(later) > 600
    for name, true in zip(("mass", "com_x", "com_y"), PUSHED, strict=False):
        assert all(abs(one.parameters[name].value - true) < 3.5 * one.parameters[name].std for one in later)
        first, last = (min(one.parameters[name].std for one in part) for part in (before, later))
        assert last < 0.8 * first
