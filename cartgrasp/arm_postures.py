"""Inverse kinematics: a posture of an arm whose tool is at a pose, by damped Gauss-Newton within the joint limits.

With the error e(q) = (p_target - p, log(R_target Rᵀ)) of the tool in {b}, m and rad, and its Jacobian J, each step is

    the least |J dq - e|² + damping |dq|²   with   lower <= q + dq <= upper,

and is taken if |e| falls; then the damping falls, else it grows.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import lsq_linear

from .frames import Array
from .spatial_pose import SpatialPose
from .urdf_arm import UrdfArm, rotation_vector

POSE_TOLERANCE = 1e-6
"""m and rad: what counts as at the pose."""
MAX_POSTURE_STEPS = 200
MAX_DAMPING = 1e8
"""A damping at which steps are below 1e-8 of the error: a local minimum."""


@dataclass(frozen=True, eq=False)
class Posture:
    """The nearest configuration (n,) that was found, and how far the tool is from the pose there, m and rad."""

    configuration: Array
    position_error: float
    rotation_error: float

    @property
    def reached(self) -> bool:
        return self.position_error <= POSE_TOLERANCE and self.rotation_error <= POSE_TOLERANCE


def find_posture(
    arm: UrdfArm, tool_pose_b: SpatialPose, start: ArrayLike | None = None, *, restarts: int = 10, seed: int = 0
) -> Posture:
    """A posture with the tool at `tool_pose_b`, sought from `start` (the middle of the joint ranges if none), then
    from drawn configurations. Where none reaches it, the nearest found: a search, not a proof that none exists."""
    found = []
    for configuration in _starts(arm, start, restarts, seed):
        found.append(_descend(arm, tool_pose_b, configuration))
        if found[-1].reached:
            return found[-1]
    return min(found, key=lambda posture: posture.position_error + posture.rotation_error)


def _starts(arm: UrdfArm, start: ArrayLike | None, restarts: int, seed: int) -> Iterator[Array]:
    middle = 0.5 * (arm.lower + arm.upper)
    yield middle if start is None else np.clip(arm.checked(start), arm.lower, arm.upper)
    rng = np.random.default_rng(seed)
    for _ in range(restarts):
        yield rng.uniform(arm.lower, arm.upper)


def _descend(arm: UrdfArm, target: SpatialPose, configuration: Array) -> Posture:
    damping, error = 1e-2, _error(arm, target, configuration)
    for _ in range(MAX_POSTURE_STEPS):
        if np.abs(error).max() <= 0.1 * POSE_TOLERANCE or damping > MAX_DAMPING:
            break
        trial = _step(arm, configuration, error, damping)
        trial_error = _error(arm, target, trial)
        if error @ error > trial_error @ trial_error:
            configuration, error, damping = trial, trial_error, max(0.1 * damping, 1e-9)
        else:
            damping *= 10.0
    return Posture(configuration, float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:])))


def _step(arm: UrdfArm, configuration: Array, error: Array, damping: float) -> Array:
    """The next configuration."""
    jacobian = arm.jacobian_a(configuration)  # with no yaw {a} has {b}'s axes
    n = len(configuration)
    free = configuration + np.linalg.solve(jacobian.T @ jacobian + damping * np.eye(n), jacobian.T @ error)
    if ((arm.lower <= free) & (free <= arm.upper)).all():
        return np.asarray(free)
    rows, sides = np.vstack([jacobian, np.sqrt(damping) * np.eye(n)]), np.concatenate([error, np.zeros(n)])
    step = lsq_linear(rows, sides, (arm.lower - configuration, arm.upper - configuration), method="bvls").x
    return np.clip(configuration + step, arm.lower, arm.upper)


def _error(arm: UrdfArm, target: SpatialPose, configuration: Array) -> Array:
    rotation, position = arm.tool_in_b(configuration)
    return np.concatenate([target.position - position, rotation_vector(target.rotation @ rotation.T)])
