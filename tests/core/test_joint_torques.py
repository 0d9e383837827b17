"""Joint torques do the work that the wrench does, and refuse what can't be meant."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp.errors import UsageError
from cartgrasp.joint_torques import JointTorques


def test_torques_do_the_work_of_the_wrench():
    """Virtual work: torque · joint velocity = wrench · twist, beside what carries the arm."""
    rng = np.random.default_rng(1)
    jacobian, gravity = rng.normal(size=(6, 7)), rng.normal(size=7)
    joints = JointTorques(jacobian, gravity, np.full(7, 100.0))
    for wrench, rate in zip(rng.normal(size=(20, 6)), rng.normal(size=(20, 7)), strict=True):
        done = (joints.torques(wrench) - gravity) @ rate
        assert done == pytest.approx(wrench @ (jacobian @ rate), rel=1e-12)
    several = rng.normal(size=(4, 3, 6))
    assert joints.torques(several)[2, 1] == pytest.approx(joints.torques(several[2, 1]))
    assert joints.n_joints == 7


def test_a_planar_two_link_arm():
    """Stretched along x, links of 0.4 and 0.3 m: a force along y turns the joints by its lever arms."""
    jacobian = np.zeros((6, 2))
    jacobian[1], jacobian[5] = (0.7, 0.3), (1.0, 1.0)
    joints = JointTorques(jacobian, [0.0, 0.0], [np.inf, 20.0])
    assert joints.torques(np.array([50.0, 10.0, 0, 0, 0, 0])) == pytest.approx([7.0, 3.0])


def test_it_keeps_its_own_numbers():
    jacobian = np.ones((6, 2))
    joints = JointTorques(jacobian, [0, 0], [1, 1])
    jacobian[:] = 0.0
    assert (joints.jacobian == 1.0).all()
    with pytest.raises(ValueError, match="read-only"):
        joints.torque_limit[0] = 5.0


@pytest.mark.parametrize(
    ("jacobian", "gravity", "limit", "words"),
    [
        (np.zeros((3, 2)), [0, 0], [1, 1], "jacobian: shape"),
        (np.zeros((6, 0)), [], [], "jacobian: shape"),
        (np.zeros((6, 2)), [0], [1, 1], "gravity_torque: shape"),
        (np.zeros((6, 2)), [0, 0], [1, 1, 1], "torque_limit: shape"),
        (np.full((6, 2), np.nan), [0, 0], [1, 1], "not finite"),
        (np.zeros((6, 2)), [0, np.inf], [1, 1], "not finite"),
        (np.zeros((6, 2)), [0, 0], [1, -1], "not >= 0"),
        (np.zeros((6, 2)), [0, 0], [1, np.nan], "not >= 0"),
        (np.zeros((6, 2)), [0, -30], [1, 20], "joint 1 needs 30 N·m .* limit of 20"),
    ],
)
def test_what_cannot_be_meant_is_refused(jacobian, gravity, limit, words):
    with pytest.raises(UsageError, match=words):
        JointTorques(jacobian, gravity, limit)


def test_joints_are_called_by_their_names():
    named = JointTorques(np.zeros((6, 2)), [0, 0], [1, 1], ("elbow", "joint_a4"))
    assert named.labels == ("joint elbow", "joint_a4")
    assert JointTorques(np.zeros((6, 2)), [0, 0], [1, 1]).labels == ("joint 0", "joint 1")
    with pytest.raises(UsageError, match="names: 2 are needed, 1 given"):
        JointTorques(np.zeros((6, 2)), [0, 0], [1, 1], ("elbow",))
    with pytest.raises(UsageError, match="joint elbow needs 30 N·m"):
        JointTorques(np.zeros((6, 2)), [30, 0], [1, 1], ("elbow", "wrist"))
