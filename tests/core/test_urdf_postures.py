"""Postures at contacts: where hands are is checked by kinematics worked out without Pinocchio."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from cartgrasp.errors import UsageError
from cartgrasp.spatial_pose import SpatialPose
from cartgrasp.urdf_arm import UrdfArm, read_urdf_arm
from cartgrasp.urdf_postures import UrdfPostures

from .drawn_arms import TOOL, DrawnArm, Joint

pytest.importorskip("pinocchio", reason="arms from a URDF need the extra `arms`")

AXES, OFFSETS = ("z", "y", "y", "z", "y", "z"), (0.1, 0.2, 0.5, 0.2, 0.3, 0.1)
SIX = DrawnArm(
    tuple(
        Joint(False, np.array([0, 0, up]), np.zeros(3), np.eye(3)["xyz".index(axis)], 0.01, np.zeros(3))
        for axis, up in zip(AXES, OFFSETS, strict=True)
    )
)
HAND, ROOT = (0.1, 1.5, 0.2), (-0.6, 0.1, 0.3)
UP, DOWN = (0.2, 0.6, 1.2, 0.2, -0.3, 0.1), (0.2, 1.6, -1.2, 0.2, 1.2, 0.1)


@pytest.fixture
def arm(tmp_path) -> UrdfArm:
    return read_urdf_arm(SIX.write(tmp_path), "tool").placed(SpatialPose.of(ROOT))


def test_the_hand_is_where_it_is_to_be_and_turned_as_asked(arm):
    postures = UrdfPostures(arm, HAND, UP)
    expected = SpatialPose.of((0, 0, 0), *HAND).rotation
    for contact in ((0.0, 0.2, 0.9), (0.0, 0.1, 0.7), (-0.1, 0.3, 0.8)):
        rotation, position = SIX.tool(postures.posture(contact).configuration)
        assert position + ROOT == pytest.approx(contact, abs=1e-6)
        assert rotation.as_matrix() == pytest.approx(expected, abs=2e-6)
        joints = postures.joints_at(contact, 0.3)
        assert joints is postures.joints_at(contact, 0.3)
        assert joints.names == arm.joints
    assert len(TOOL) == 3


def test_a_hand_that_goes_a_little_way_takes_its_posture_along(arm):
    """Which elbow it is, the start says; along a handle no joint jumps."""
    bent = []
    for start in (UP, DOWN):
        postures = UrdfPostures(arm, HAND, start)
        found = [postures.posture((0.0, y, 0.8)) for y in np.linspace(0.3, -0.1, 41).tolist()]
        assert all(posture.reached for posture in found)
        steps = [np.abs(b.configuration - a.configuration).max() for a, b in pairwise(found)]
        assert max(steps) < 0.1
        bent.append(found[-1].configuration[2])
    assert bent[0] > 0 > bent[1]


def test_what_is_remembered_is_bounded(arm, monkeypatch):
    monkeypatch.setattr("cartgrasp.urdf_postures.MAX_CACHED_POSTURES", 3)
    postures = UrdfPostures(arm, HAND, UP)
    found = [postures.posture((0.0, y, 0.8)) for y in np.linspace(0.3, 0.2, 11).tolist()]
    assert all(posture.reached for posture in found)
    assert len(postures._here) <= 3


@pytest.mark.parametrize("contact", [(3.0, 0.0, 1.0), (0.0, 0.1, 3.0)])
def test_where_no_posture_was_found_it_says_how_near_one_comes(arm, contact):
    postures = UrdfPostures(arm, HAND, UP)
    assert postures.posture((0.0, 0.2, 0.9)).reached
    with pytest.raises(UsageError, match=r"no posture was found with the hand at .*; the nearest stays .* m and"):
        postures.joints_at(contact, 0.0)


@pytest.mark.parametrize(("given", "words"), [((0, 1), "3 numbers"), ((0, 0, np.inf), "hand"), ("abc", "hand")])
def test_a_hand_is_three_angles(arm, given, words):
    with pytest.raises(UsageError, match=words):
        UrdfPostures(arm, given)


def test_postures_are_of_an_arm_that_was_read():
    with pytest.raises(UsageError, match=r"urdf postures: arm: 'arm\.urdf' is no UrdfArm"):
        UrdfPostures("arm.urdf")
