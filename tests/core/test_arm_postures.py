"""Inverse kinematics: what is reached is checked by forward kinematics; what can't be is said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cartgrasp.arm_postures import POSE_TOLERANCE, find_posture
from cartgrasp.errors import UsageError
from cartgrasp.spatial_pose import SpatialPose
from cartgrasp.urdf_arm import UrdfArm, read_urdf_arm

from .drawn import vectors
from .drawn_arms import DrawnArm, arms
from .test_urdf_arm import PLANAR, written

pytest.importorskip("pinocchio", reason="arms from a URDF need the extra `arms`")


@pytest.fixture
def planar(tmp_path: Path) -> UrdfArm:
    return read_urdf_arm(written(tmp_path), "tool")


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(arm=arms(), data=st.data())
def test_a_pose_that_the_arm_had_is_found_again(arm: DrawnArm, data: st.DataObject, tmp_path: Path):
    """From nearby; every joint stays in its range."""
    there = data.draw(vectors(len(arm.joints), -3, 3))
    start = np.clip(there + data.draw(vectors(len(arm.joints), -0.1, 0.1)), -3, 3)
    read = read_urdf_arm(arm.write(tmp_path), "tool")
    rotation, position = arm.tool(there)
    posture = find_posture(read, SpatialPose(rotation.as_matrix(), position), start)
    assert posture.reached, posture
    assert (np.abs(posture.configuration) <= 3).all()
    found_rotation, found_position = arm.tool(posture.configuration)
    assert np.linalg.norm(found_position - position) == pytest.approx(posture.position_error, abs=1e-12)
    assert np.linalg.norm(found_position - position) <= POSE_TOLERANCE
    assert (found_rotation * rotation.inv()).magnitude() <= POSE_TOLERANCE + 1e-12


def test_planar_arm_reaches_as_the_law_of_cosines_says(planar: UrdfArm):
    target = planar.tool_pose_b((0.4, 1.2))
    posture = find_posture(planar, target)
    np.testing.assert_allclose(posture.configuration, [0.4, 1.2], atol=1e-5)
    distance = np.linalg.norm(target.position)
    assert np.cos(posture.configuration[1]) == pytest.approx(
        (distance**2 - 0.5**2 - 0.4**2) / (2 * 0.5 * 0.4), abs=1e-5
    )


def test_out_of_reach_is_said_by_how_much(planar: UrdfArm):
    """The arm is 0.9 m long: the point 1.2 m away is 0.3 m too far."""
    posture = find_posture(planar, SpatialPose.of((1.2, 0.0, 0.0)))
    assert not posture.reached
    assert posture.position_error == pytest.approx(0.3, abs=1e-3)


def test_limits_of_joints_are_kept_where_the_pose_lies_beyond_them(tmp_path: Path):
    narrow = read_urdf_arm(written(tmp_path, PLANAR.replace('lower="-3" upper="3"', 'lower="-1" upper="1"')), "tool")
    posture = find_posture(narrow, read_urdf_arm(written(tmp_path), "tool").tool_pose_b((0.5, 1.5)))
    assert not posture.reached
    assert (np.abs(posture.configuration) <= 1).all()


@pytest.mark.long
@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(arm=arms(), far=vectors(6, -3, 3), start=vectors(7, -3, 3))
def test_where_it_stops_no_joint_can_help(arm: DrawnArm, far: np.ndarray, start: np.ndarray, tmp_path: Path):
    """Poses mostly out of reach, from starts at the ends of ranges: no joint moved by 0.01 within its range takes more
    than a thousandth off the squared error; a slope left over takes ten times that."""
    read = read_urdf_arm(arm.write(tmp_path), "tool")
    target = SpatialPose.of(far[:3], *far[3:])
    ends = np.where(np.abs(start) > 1.5, 3.0 * np.sign(start), start)[: len(arm.joints)]
    posture = find_posture(read, target, ends, restarts=0)

    def error(configuration: np.ndarray) -> float:
        rotation, position = arm.tool(configuration)
        turn = (Rotation.from_matrix(target.rotation) * rotation.inv()).magnitude()
        return float(np.sum((target.position - position) ** 2) + turn**2)

    there = error(posture.configuration)
    assert there == pytest.approx(posture.position_error**2 + posture.rotation_error**2, abs=1e-9)
    for move in 0.01 * np.concatenate([np.eye(len(ends)), -np.eye(len(ends))]):
        assert error(np.clip(posture.configuration + move, -3, 3)) >= there * (1 - 1e-3) - 1e-9


def test_the_start_chooses_among_postures(tmp_path: Path):
    """Three joints in a plane, hand turned as asked: elbow up and elbow down both reach."""
    wrist = PLANAR.replace('name="wrist" type="fixed"', 'name="wrist" type="revolute"').replace(
        '<origin xyz="0.4 0 0"/></joint>\n<link name="tool"/>',
        '<origin xyz="0.4 0 0"/><axis xyz="0 -1 0"/><limit lower="-3" upper="3" effort="9" velocity="1"/></joint>'
        '<link name="tool"/>',
    )
    arm = read_urdf_arm(written(tmp_path, wrist), "tool")
    target = SpatialPose.of((0.6, 0.0, 0.1))
    up, down = find_posture(arm, target, (0.8, -1.5, 0.5)), find_posture(arm, target, (-0.8, 1.5, -0.5))
    assert up.reached
    assert down.reached
    assert up.configuration[1] < 0 < down.configuration[1]


@pytest.mark.parametrize("start", [(0.1,), (0.1, np.nan)])
def test_a_start_is_a_configuration(planar: UrdfArm, start):
    with pytest.raises(UsageError, match="a configuration is 2 finite numbers"):
        find_posture(planar, SpatialPose.of((0.5, 0, 0)), start)
