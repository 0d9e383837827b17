"""Arms from URDFs: against kinematics worked out without Pinocchio, finite differences, and a closed form."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cartgrasp.errors import FileError, UsageError
from cartgrasp.spatial_pose import SpatialPose
from cartgrasp.urdf_arm import LEVEL_GRAVITY, LinkMass, read_urdf_arm

from .drawn import numbers, vectors
from .drawn_arms import DrawnArm, arms

pinocchio = pytest.importorskip("pinocchio", reason="arms from a URDF need the extra `arms`")

STEP = 1e-5
DIFFERENCES = 1e-7
"""Second-order central differences of arms of a few metres and 60 kg: h² f‴/6 is 1e-8, rounding 1e-9."""

PLANAR = """
<robot name="planar 2R"><link name="base"/>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 -1 0"/>
<limit lower="-3" upper="3" effort="50" velocity="1"/></joint>
<link name="upper"><inertial><origin xyz="0.25 0 0"/><mass value="3"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.5 0 0"/>
<axis xyz="0 -1 0"/><limit lower="-3" upper="3" effort="20" velocity="1"/></joint>
<link name="fore"><inertial><origin xyz="0.2 0 0"/><mass value="2"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="wrist" type="fixed"><parent link="fore"/><child link="tool"/><origin xyz="0.4 0 0"/></joint>
<link name="tool"/>
<joint name="finger" type="prismatic"><parent link="tool"/><child link="tip"/><axis xyz="1 0 0"/>
<limit lower="0" upper="0.1" effort="5" velocity="1"/></joint><link name="tip"/></robot>
"""

every_arm = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


def written(folder: Path, text: str = PLANAR) -> Path:
    path = folder / "arm.urdf"
    path.write_text(text, encoding="utf-8")
    return path


def configurations(arm: DrawnArm, data: st.DataObject) -> np.ndarray:
    return data.draw(vectors(len(arm.joints), -3, 3))


@every_arm
@given(arm=arms(), data=st.data())
def test_tool_stands_where_the_joints_put_it(arm: DrawnArm, data: st.DataObject, tmp_path: Path):
    configuration, base = configurations(arm, data), data.draw(vectors(6, -2, 2))
    pose_br = SpatialPose.of(base[:3], *base[3:])
    pose = read_urdf_arm(arm.write(tmp_path), "tool").placed(pose_br).tool_pose_b(configuration)
    rotation, position = arm.tool(configuration)
    np.testing.assert_allclose(pose.position, pose_br.rotation @ position + pose_br.position, atol=1e-12)
    np.testing.assert_allclose(pose.rotation, pose_br.rotation @ rotation.as_matrix(), atol=1e-12)


@every_arm
@given(arm=arms(), yaw=numbers(-3, 3), data=st.data())
def test_jacobian_is_how_the_tool_moves(arm: DrawnArm, yaw: float, data: st.DataObject, tmp_path: Path):
    configuration, base = configurations(arm, data), data.draw(vectors(3, -2, 2))
    pose_br = SpatialPose.of((0.3, -0.2, 0.5), *base)
    rotation_ar = (Rotation.from_euler("z", -yaw) * Rotation.from_euler("xyz", base)).as_matrix()
    columns = []
    for step in STEP * np.eye(len(configuration)):
        rotation, position = arm.tool(configuration + step)
        rotation_back, position_back = arm.tool(configuration - step)
        turn = (rotation * rotation_back.inv()).as_rotvec()
        columns.append(np.concatenate([rotation_ar @ (position - position_back), rotation_ar @ turn]) / (2 * STEP))
    jacobian = read_urdf_arm(arm.write(tmp_path), "tool").placed(pose_br).jacobian_a(configuration, yaw)
    np.testing.assert_allclose(jacobian, np.transpose(columns), atol=DIFFERENCES)


@every_arm
@given(arm=arms(), data=st.data())
def test_gravity_torque_is_the_slope_of_potential_energy(arm: DrawnArm, data: st.DataObject, tmp_path: Path):
    """On a floor that is tilted under a base that is turned."""
    configuration, base = configurations(arm, data), data.draw(vectors(3, -2, 2))
    gravity_b = data.draw(vectors(3, -9, 9))
    gravity_r = Rotation.from_euler("xyz", base).inv().apply(gravity_b)
    slope = [
        (arm.potential(configuration + step, gravity_r) - arm.potential(configuration - step, gravity_r)) / (2 * STEP)
        for step in STEP * np.eye(len(configuration))
    ]
    placed = read_urdf_arm(arm.write(tmp_path), "tool").placed(SpatialPose.of((1, 2, 3), *base), gravity_b)
    np.testing.assert_allclose(placed.gravity_torque(configuration), slope, atol=1e2 * DIFFERENCES)


@given(numbers(-3, 3), numbers(-3, 3))
@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_planar_arm_in_closed_form(tmp_path: Path, shoulder: float, elbow: float):
    """Two links in the x-z plane, angles up from x: what a student writes down."""
    arm = read_urdf_arm(written(tmp_path), "tool")
    reach = shoulder + elbow
    x, z = 0.5 * np.cos(shoulder) + 0.4 * np.cos(reach), 0.5 * np.sin(shoulder) + 0.4 * np.sin(reach)
    np.testing.assert_allclose(arm.tool_pose_b((shoulder, elbow)).position, [x, 0, z], atol=1e-12)
    expected = np.zeros((6, 2))
    expected[0], expected[2], expected[4] = (-z, -0.4 * np.sin(reach)), (x, 0.4 * np.cos(reach)), (-1, -1)
    np.testing.assert_allclose(arm.jacobian_a((shoulder, elbow)), expected, atol=1e-12)
    weight_elbow = 2 * 9.81 * 0.2 * np.cos(reach)
    weight = [3 * 9.81 * 0.25 * np.cos(shoulder) + 2 * 9.81 * 0.5 * np.cos(shoulder) + weight_elbow, weight_elbow]
    np.testing.assert_allclose(arm.gravity_torque((shoulder, elbow)), weight, atol=1e-12)


def test_what_moves_the_tool_is_the_arm_and_limits_are_the_files(tmp_path: Path):
    arm = read_urdf_arm(written(tmp_path), "tool")
    assert arm.joints == ("shoulder", "elbow")
    np.testing.assert_array_equal(arm.torque_limit, [50, 20])
    np.testing.assert_array_equal(np.stack([arm.lower, arm.upper]), [[-3, -3], [3, 3]])
    assert read_urdf_arm(written(tmp_path), "tip").joints == ("shoulder", "elbow", "finger")
    joints = read_urdf_arm(written(tmp_path), "tool", torque_limit=(40, np.inf)).joint_torques((0.3, -0.4), yaw=0.2)
    np.testing.assert_array_equal(joints.torque_limit, [40, np.inf])
    np.testing.assert_array_equal(joints.jacobian, arm.jacobian_a((0.3, -0.4), 0.2))
    np.testing.assert_array_equal(joints.gravity_torque, arm.gravity_torque((0.3, -0.4)))


def test_a_joint_may_be_called_as_its_link(tmp_path: Path):
    arm = read_urdf_arm(written(tmp_path, PLANAR.replace('name="finger"', 'name="tip"')), "tip")
    assert arm.joints == ("shoulder", "elbow", "tip")
    np.testing.assert_allclose(arm.tool_pose_b((0, 0, 0.05)).position, [0.95, 0, 0], atol=1e-12)


def test_a_push_forward_needs_the_shoulder_to_turn_forward(tmp_path: Path):
    """An arm that points straight up, 0.9 m: 10 N on the cart are 9 N·m, and angles fall as the tool goes forward."""
    arm = read_urdf_arm(written(tmp_path), "tool").placed(SpatialPose.of((0, 0, 0)), (0, 0, 0))
    torques = arm.joint_torques((np.pi / 2, 0.0)).torques(np.array([10.0, 0, 0, 0, 0, 0]))
    np.testing.assert_allclose(torques, [-9.0, -4.0], atol=1e-12)


def test_added_masses_weigh_as_those_of_the_file(tmp_path: Path):
    bare = written(tmp_path, PLANAR.replace('<mass value="2"/>', '<mass value="0"/>'))
    arm = read_urdf_arm(
        bare, "tool", added_masses=[LinkMass("fore", 1.5, (0.2, 0, 0)), LinkMass("tool", 0.5, (-0.2, 0, 0))]
    )
    whole = read_urdf_arm(written(tmp_path), "tool")
    np.testing.assert_allclose(arm.gravity_torque((0.4, -1.0)), whole.gravity_torque((0.4, -1.0)), atol=1e-12)


def test_gravity_may_be_left_out_but_not_by_oversight(tmp_path: Path):
    """A mass of the base, which doesn't move, is none of the arm."""
    bare = written(tmp_path, re.sub('<mass value="."/>', '<mass value="0"/>', PLANAR))
    weightless = read_urdf_arm(bare, "tool", added_masses=[LinkMass("base", 5.0, (0, 0, 0))])
    with pytest.raises(UsageError, match=r"no moving link has a mass: give added_masses, or gravity_b=\(0, 0, 0\)"):
        weightless.joint_torques((0.4, -1.0))
    assert not weightless.placed(SpatialPose.of((0, 0, 0)), (0, 0, 0)).gravity_torque((0.4, -1.0)).any()
    assert LEVEL_GRAVITY == (0.0, 0.0, -9.81)


@pytest.mark.parametrize(
    ("change", "arguments", "words"),
    [
        (("", ""), {"tool": "hand"}, "tool: no link is called 'hand'; there are base, upper, fore, tool, tip"),
        (("", ""), {"tool": "base"}, "tool: no joint moves 'base'"),
        (('effort="50"', 'effort="0"'), {}, "joint shoulder: torque limit 0 is not > 0; give torque_limit"),
        (("", ""), {"torque_limit": (40, np.nan)}, "joint elbow: torque limit nan is not > 0"),
        (("", ""), {"torque_limit": (40,)}, "torque_limit: 2 numbers are needed, 1 given"),
        (("", ""), {"added_masses": [LinkMass("hand", 1, (0, 0, 0))]}, "added_masses: no link is called 'hand'"),
        (("", ""), {"added_masses": [LinkMass("fore", -1, (0, 0, 0))]}, "needs a finite mass >= 0"),
        (("", ""), {"added_masses": [LinkMass("fore", 1, (0, np.nan, 0))]}, "needs a finite mass >= 0"),
        (("", ""), {"added_masses": [LinkMass("fore", 1, (0, 0))]}, "needs a finite mass >= 0"),
        (("", ""), {"added_masses": [("fore", 1, (0, 0, 0))]}, r"added_masses: \('fore'.* is no LinkMass"),
        (('name="elbow" type="revolute"', 'name="elbow" type="continuous"'), {}, "joint elbow: give it limits"),
        (('name="elbow" type="revolute"', 'name="elbow" type="floating"'), {}, "joint elbow: give it limits"),
        (('lower="-3" upper="3"', 'lower="3" upper="-3"'), {}, "joint shoulder: no range: lower 3, upper -3"),
        (
            ('lower="-3" upper="3"', 'lower="-3" upper="1e300"'),
            {},
            r"joint shoulder: no range: lower -3, upper 1e\+300",
        ),
        (('name="shoulder"', 'name="upper"'), {}, "joints that don't move 'tool' can't be held: Several frames"),
    ],
)
def test_what_cannot_be_meant_is_refused(change, arguments, words, tmp_path: Path):
    path = written(tmp_path, PLANAR.replace(*change) if change[0] else PLANAR)
    with pytest.raises(UsageError, match=words):
        read_urdf_arm(path, **{"tool": "tool", **arguments})


def test_a_place_is_a_pose(tmp_path: Path):
    with pytest.raises(UsageError, match=r"pose_br: \(1, 2, 3\) is no SpatialPose"):
        read_urdf_arm(written(tmp_path), "tool").placed((1, 2, 3))


@pytest.mark.parametrize("gravity", [(0, 0), (0, 0, np.inf), (0, np.nan, 0)])
def test_gravity_is_three_finite_numbers(gravity, tmp_path: Path):
    with pytest.raises(UsageError, match=r"gravity_b: .* is not three finite numbers"):
        read_urdf_arm(written(tmp_path), "tool").placed(SpatialPose.of((0, 0, 0)), gravity)


@pytest.mark.parametrize(
    "text", ["", "robot", "<robot", "<robot name='a'/>", PLANAR.replace('parent link="upper"', 'parent link="none"')]
)
def test_what_is_no_urdf_is_refused_with_its_place(text: str, tmp_path: Path):
    with pytest.raises(FileError, match=r"arm\.urdf: is no URDF"):
        read_urdf_arm(written(tmp_path, text), "tool")


def test_a_file_that_cannot_be_read_is_refused(tmp_path: Path):
    with pytest.raises(FileError, match=r"none\.urdf: can't be read"):
        read_urdf_arm(tmp_path / "none.urdf", "tool")
    (tmp_path / "arm.urdf").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FileError, match=r"arm\.urdf: can't be read"):
        read_urdf_arm(tmp_path / "arm.urdf", "tool")


@pytest.mark.parametrize("configuration", [(0.1,), (0.1, np.nan), (0.1, np.inf), ((0.1, 0.2),)])
def test_a_configuration_is_a_finite_number_for_each_joint(configuration, tmp_path: Path):
    arm = read_urdf_arm(written(tmp_path), "tool")
    for ask in (arm.tool_pose_b, arm.jacobian_a, arm.gravity_torque, arm.joint_torques):
        with pytest.raises(UsageError, match=r"2 finite numbers \(shoulder, elbow\)"):
            ask(configuration)


def test_without_the_extra_it_says_how_to_get_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    with pytest.raises(UsageError, match=r"pip install '\.\[arms\]'"):
        read_urdf_arm(written(tmp_path), "tool")
