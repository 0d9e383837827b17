"""A tracker that follows another point of the cart, by vectors in the floor that are added by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from cartgrasp.effects import ContactOffset, PoseOffset, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import RunLog
from cartgrasp.logs.alignment import at_body
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement, Motion
from cartgrasp.simulation.sensors import SensorNoise, Sensors
from cartgrasp.tracked_point import TrackedPoint
from estimation import CartFilter, FilterNoise, RegressorEstimator
from estimation.online.paper_filter import PaperFilter
from estimation.whole_log.identification import identify
from estimation.whole_log.replay import replay
from tests.core.drawn import vectors

from .free_body import STEP, driven, pushes, recorded, turned

CART, NO_TOOL = (24.0, 0.3, 0.05, 2.0, 3.0, 1.0), (0.0, 0.0, 0.0, 0.0)
GUESS = CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(ViscousDrag(2.0, 1.0),))
AHEAD = PoseOffset(-0.06)
CONTACT = np.array([-0.25, 0.1, 1.0])
NOISE = (0.0004, 0.005, 3.0, 0.1)
QUIET = SensorNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def tracked(log, point, yaw):
    """A log of {b} as of a point (2,) of the cart whose axis is turned by `yaw` in {b}."""
    arms = np.array([turned(heading) @ point for heading in log.pose[:, 2]])
    pose, velocity = log.pose + np.column_stack([arms, np.full(len(log), yaw)]), log.velocity.copy()
    velocity[:, 0] -= log.velocity[:, 2] * arms[:, 1]
    velocity[:, 1] += log.velocity[:, 2] * arms[:, 0]
    return replace(log, pose=pose, velocity=velocity)


def log_of(point=(0.06, 0.0), yaw=0.0, duration=18.0):
    time = STEP * np.arange(round(duration / STEP))
    contacts, given = np.tile(CONTACT, (len(time), 1)), pushes(time)
    states, _ = driven(given, CART, NO_TOOL, contacts)
    return tracked(recorded(states, contacts, given, NOISE), np.array(point), yaw)


@given(pose=vectors(3, -3.0, 3.0), nu=vectors(2, -2.0, 2.0), offset=vectors(3, -0.5, 0.5))
def test_sensors_follow_the_tracked_point_and_a_log_is_brought_back(pose, nu, offset):
    """{b} is where the offset says it is in the recorded frame; velocities are those of its origin."""
    cart = GUESS.with_effect(PoseOffset(*offset))
    told, plain = (Sensors(one, QUIET).motion(0.0, Motion(pose, nu)) for one in (cart, GUESS))
    expected = np.append(told.pose[:2] + turned(told.pose[2]) @ offset[:2], told.pose[2] + offset[2])
    np.testing.assert_allclose(expected, pose, atol=1e-12)
    h = 1e-6
    further = np.append(pose[:2] + h * plain.velocity[:2], pose[2] + h * nu[1])
    moved = Sensors(cart, QUIET).motion(0.0, Motion(further, nu)).pose
    np.testing.assert_allclose((moved - told.pose) / h, told.velocity, atol=1e-4)
    log = RunLog(np.zeros(1), told.pose[None], told.velocity[None], {})
    back = at_body(log, cart)
    np.testing.assert_allclose(back.pose[0], plain.pose, atol=1e-12)
    np.testing.assert_allclose(back.velocity[0], plain.velocity, atol=1e-12)
    again = TrackedPoint(cart.pose_tb).at_body(told)
    np.testing.assert_allclose(np.r_[again.pose, again.velocity], np.r_[plain.pose, plain.velocity], atol=1e-12)


def test_velocities_that_come_alone_take_the_heading_that_was_seen_last():
    point = TrackedPoint(np.array([0.1, 0.0, 0.0]))
    alone = Measurement(0.0, velocity=np.array([0.3, 0.0, 1.0]))
    assert np.isnan(point.at_body(alone).velocity[:2]).all()
    point.at_body(Measurement(1.0, pose=np.array([0.0, 0.0, 0.5])))
    found = point.at_body(Measurement(1.2, velocity=np.array([0.3, 0.0, 1.0]))).velocity
    np.testing.assert_allclose(found, [0.3 - 0.1 * np.sin(0.7), 0.1 * np.cos(0.7), 1.0])
    partly = point.at_body(Measurement(1.3, pose=np.array([1.0, 2.0, np.nan])))
    assert np.isnan(partly.pose).all()
    only_turned = TrackedPoint(np.array([0.0, 0.0, 0.2]))
    kept = only_turned.at_body(Measurement(1.3, pose=np.array([1.0, 2.0, np.nan]))).pose
    np.testing.assert_array_equal(kept, [1.0, 2.0, np.nan])


def test_two_offsets_are_one_after_another():
    cart = GUESS.with_effect(PoseOffset(0.1, 0.0, np.pi / 2)).with_effect(PoseOffset(0.2, label="more"))
    np.testing.assert_allclose(cart.pose_tb, [0.1, 0.2, np.pi / 2])
    assert len(cart.pose_indices) == 6
    assert not GUESS.with_effect(ContactOffset(0.1)).pose_tb.any()


def test_a_log_of_the_body_stays_itself():
    log = log_of()
    assert at_body(log, GUESS) is log


@pytest.mark.long
def test_the_filter_brings_what_it_sees_to_the_body():
    """6 cm ahead of the axle it says `outliers`, and that its velocities don't fit; told of it, nothing is wrong."""
    noise = FilterNoise(*(NOISE[0],) * 2, *(NOISE[1],) * 2, *NOISE[2:])
    log, knowing = log_of(duration=12.0), GUESS.with_effect(AHEAD)
    told = replay(log, CartFilter(knowing, ["hand"], noise=noise))
    unaware = replay(log, CartFilter(GUESS, ["hand"], noise=noise))
    plain = replay(log_of((0.0, 0.0), duration=12.0), CartFilter(GUESS, ["hand"], noise=noise)).last
    assert {str(one.health) for one in told.estimates[100:]} == {"ok"}
    assert {str(one.health) for one in unaware.estimates[100:]} != {"ok"}
    for name in ("mass", "com_x", "com_y", "inertia"):
        assert told.last.parameters[name].value == pytest.approx(plain.parameters[name].value, abs=1e-3)
    other = replay(log, RegressorEstimator(knowing, ["hand"], noise=noise)).last.parameters["mass"]
    assert abs(other.value - 24.0) < 3 * other.std
    short = log_of(duration=3.0)
    brought, literal = (
        replay(one, PaperFilter(cart)).last for one, cart in ((short, knowing), (at_body(short, knowing), GUESS))
    )
    assert brought.parameters == literal.parameters


@pytest.mark.long
@pytest.mark.some(1)
@pytest.mark.parametrize(
    ("point", "yaw"), [((0.06, 0.0), 0.0), ((0.1, -0.2), 0.03), ((-0.5, 0.3), 1.5)], ids=["ahead", "aside", "elsewhere"]
)
def test_identify_finds_where_the_body_is(point, yaw):
    """From a guess nearby; the CoM, the mass and the inertia are those of {b}."""
    true = np.append(-turned(-yaw) @ point, -yaw)
    near = PoseOffset(*(true + np.array([0.02, -0.02, 0.02])))
    found = identify([log_of(point, yaw)], GUESS.with_effect(near)).parameters
    expected = {"mass": 24.0, "com_x": 0.3, "com_y": 0.05, "inertia": 2.0}
    expected |= {f"pose_offset.{name}": value for name, value in zip(("x", "y", "yaw"), true, strict=True)}
    for name, value in expected.items():
        assert abs(found[name].value - value) < 3.5 * found[name].std, name
    assert min(found["pose_offset.x"].std, found["pose_offset.y"].std) < 0.003


def test_an_older_pose_turns_no_later_velocity():
    """It may be refused, too, for it came too late. With its own pose a velocity goes by that."""
    point, turning = TrackedPoint(np.array([-0.5, 0.0, 0.0])), np.array([0.0, 0.0, 0.3])
    point.at_body(Measurement(100.0, pose=np.array([0.0, 0.0, 0.0]), velocity=turning))
    late = Measurement(99.0, pose=np.array([0.0, 0.0, 0.5 * np.pi]), velocity=turning)
    np.testing.assert_allclose(point.at_body(late).velocity, [0.15, 0.0, 0.3], atol=1e-12)
    np.testing.assert_allclose(point.at_body(Measurement(100.0, velocity=turning)).velocity, [0.0, -0.15, 0.3])
