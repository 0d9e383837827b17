"""Spatial poses: they compose as their matrices do, and refuse what is no rotation."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from scipy.spatial.transform import Rotation

from cartgrasp.errors import UsageError
from cartgrasp.spatial_pose import SpatialPose

from .drawn import vectors


def matrix(pose: SpatialPose) -> np.ndarray:
    return np.block([[pose.rotation, pose.position[:, None]], [np.zeros((1, 3)), np.ones((1, 1))]])


@given(vectors(6, -3, 3), vectors(6, -3, 3))
def test_poses_compose_as_their_matrices(first: np.ndarray, second: np.ndarray):
    pose_ab, pose_bc = SpatialPose.of(first[:3], *first[3:]), SpatialPose.of(second[:3], *second[3:])
    np.testing.assert_allclose(matrix(pose_ab @ pose_bc), matrix(pose_ab) @ matrix(pose_bc), atol=1e-12)


@given(vectors(3, -3, 3))
def test_angles_turn_about_fixed_axes_as_scipys_do(angles: np.ndarray):
    expected = Rotation.from_euler("xyz", angles).as_matrix()
    np.testing.assert_allclose(SpatialPose.of((0, 0, 0), *angles).rotation, expected, atol=1e-12)


def test_a_pose_does_not_change_with_the_arrays_it_was_made_of():
    position = np.zeros(3)
    pose = SpatialPose(np.eye(3), position)
    position[0] = 1.0
    assert pose.position[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        pose.position[0] = 1.0


@pytest.mark.parametrize(
    ("rotation", "position", "words"),
    [
        (np.eye(3), (0, 0), "position: .* is not"),
        (np.eye(3), (0, 0, np.nan), "position: .* is not"),
        (np.eye(4), (0, 0, 0), "rotation: .* is not"),
        (np.diag([1, 1, -1]), (0, 0, 0), "right-handed rotation"),
        (1.001 * np.eye(3), (0, 0, 0), "right-handed rotation"),
    ],
)
def test_what_is_no_pose_is_refused(rotation, position, words):
    with pytest.raises(UsageError, match=words):
        SpatialPose(rotation, position)
