"""`urdf:` of an arm: the same limits as those of the posture that Python finds, and where exactly a mistake is."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp.errors import FileError
from cartgrasp.spatial_pose import SpatialPose
from cartgrasp.studies.campaigns.study_file import read_study
from cartgrasp.urdf_arm import read_urdf_arm
from cartgrasp.urdf_postures import UrdfPostures
from planning import Pull
from planning.problem.problem_file import read_problem

from ...docs.given import a_robot
from .test_problem_file import CART, problem_file

pytest.importorskip("pinocchio", reason="arms from a URDF need the extra `arms`")

JOINTS = "{jacobian: [[1], [1], [1], [1], [1], [1]], gravity_torque: [0], torque_limit: [1]}"
URDF = """\
    urdf:
      file: robots/arm.urdf
      tool: tool0
      base: [-0.7, 0.2, 0.3]
      hand_turned: [0.0, 1.57, 0.0]
      start: [0.1, 0.6, 1.2, 0.1, -0.3, 0.1]
      torque_limit: [60, 60, 60, 60, 60, 60]
"""
PROBLEM = f"""\
cart: cart.yaml
wrench: [40.0, 0.0, 3.0]
arms:
  - name: left
    contacts: [[0.0, 0.2, 0.9]]
    limits: {{force: [150, 150, 150], moment: [15, 15, 15]}}
{URDF}"""
STUDY = f"""\
name: few
runs: 1
closed_loop:
  cart: cart.yaml
  duration: 0.4
  arms:
  - name: left
    contacts: [[0.0, 0.2, 0.9]]
    limits: {{force: [150, 150, 150], moment: [15, 15, 15]}}
{URDF}"""


@pytest.fixture
def robot(tmp_path):
    (tmp_path / "robots").mkdir()
    return a_robot(tmp_path / "robots")


def test_limits_are_those_of_the_posture(tmp_path, robot):
    (left,) = read_problem(problem_file(tmp_path, PROBLEM)).arms
    arm = read_urdf_arm(robot, "tool0", torque_limit=[60] * 6).placed(SpatialPose.of((-0.7, 0.2, 0.3)))
    bears = UrdfPostures(arm, (0, 1.57, 0), (0.1, 0.6, 1.2, 0.1, -0.3, 0.1)).joints_at((0.0, 0.2, 0.9), 0.0)
    np.testing.assert_allclose(left.joints.jacobian, bears.jacobian, atol=1e-12)
    np.testing.assert_allclose(left.joints.gravity_torque, bears.gravity_torque, atol=1e-12)
    assert left.postures is not None


def test_weight_is_left_out_or_added(tmp_path, robot):
    text = PROBLEM + "      feels_gravity: false\n"
    (left,) = read_problem(problem_file(tmp_path, text)).arms
    assert not left.joints.gravity_torque.any()
    text = PROBLEM + "      added_masses: [{link: tool0, mass: 1.0, centre: [0, 0, 0]}]\n"
    (laden,) = read_problem(problem_file(tmp_path, text)).arms
    (bare,) = read_problem(problem_file(tmp_path, PROBLEM)).arms
    felt = laden.joints.gravity_torque - bare.joints.gravity_torque
    np.testing.assert_allclose(felt, 9.81 * bare.joints.jacobian[2], atol=1e-3)  # what holds 1 kg up at the tool


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("robots/arm.urdf", "robots/none.urdf", "problem.yaml:7:5: arms.0.urdf: .*none.urdf: can't be read"),
        ("tool: tool0", "tool: tool1", "problem.yaml:7:5: arms.0.urdf: .*no link is called 'tool1'"),
        ("[-0.7, 0.2, 0.3]", "[-3.7, 0.2, 0.3]", "problem.yaml:4:5: arms.0.name: arm left: no posture was found"),
        (
            "      tool: tool0\n",
            "      tool: tool0\n      base_turned: [0, 0, 90]\n",
            "arms.0.urdf: base_turned: .*rad: 90 is not",
        ),
        ("[60, 60,", "[60, -60,", "arms.0.urdf.torque_limit.1: -60 is not > 0"),
        ("      tool: tool0\n", "", "arms.0.urdf.tool: is missing"),
        ("    urdf:", f"    joints: {JOINTS}\n    urdf:", "arms.0.urdf: stands beside `joints`"),
    ],
)
def test_mistakes_are_told_where_they_are(tmp_path, robot, old, new, said):
    with pytest.raises(FileError, match=said):
        read_problem(problem_file(tmp_path, PROBLEM.replace(old, new)))


def test_a_study_runs_with_the_posture_and_tells_what_the_file_says(tmp_path, robot):
    (tmp_path / "cart.yaml").write_text(CART)
    path = tmp_path / "study.yaml"
    path.write_text(STUDY)
    study = read_study(path)
    (told,) = study.told["closed_loop"]["arms"]
    assert told["urdf"]["file"] == robot.read_text()
    record = study.scenario.run()
    assert set(record.statuses) == {"optimal"}
    path.write_text(STUDY.replace("arm.urdf", "none.urdf"))
    with pytest.raises(FileError, match=r"arms.0.urdf: .*none.urdf: can't be read"):
        read_study(path)
    path.write_text(STUDY.replace(URDF, ""))
    (told,) = read_study(path).told["closed_loop"]["arms"]
    assert "urdf" not in told


def test_a_limit_of_an_arm_has_its_key(tmp_path):
    """And what it has against its numbers is told at its place."""
    text = PROBLEM.replace(URDF, "").replace("moment: [15, 15, 15]", "pull: {bound: 18}")
    (left,) = read_problem(problem_file(tmp_path, text)).arms
    assert left.limits == (Pull(18.0),)
    assert left.force_limit == (150, 150, 150)
    with pytest.raises(FileError, match=r"problem\.yaml:6:\d+: arms\.0\.limits\.pull\.bound: -1"):
        read_problem(problem_file(tmp_path, text.replace("18", "-1")))
