"""Poses of a tracked frame, in space, as planar poses of {b}; and their velocity."""

from __future__ import annotations

import numpy as np

from ...frames import Array, body_to_world, rotation_planar, unwrapped
from .resampling import stretches
from .smoothing_spline import MIN_SPLINE_SAMPLES, spline_at_noise

MAX_TILT = 0.35
"""rad: a frame whose z is farther off the vertical has no heading."""
QUATERNION_NORM_TOLERANCE = 0.01


def planar(numbers: Array) -> Array:
    """x, y, yaw (n, 3) of poses (n, 7); yaw is unwrapped over the samples that are there."""
    x, y, z, w = numbers[:, 3:7].T
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.column_stack([numbers[:, :2], unwrapped(yaw)])


def tilt(numbers: Array) -> float:
    """The largest angle between the tracked frame's z and the vertical, rad."""
    x, y = numbers[:, 3], numbers[:, 4]
    upright = 1 - 2 * (x * x + y * y)
    return float(np.arccos(np.clip(np.nanmin(upright), -1, 1))) if np.isfinite(upright).any() else 0.0


def of_body(pose: Array, body: Array) -> Array:
    """Poses (n, 3) of {b}, whose pose in the tracked frame is `body`."""
    moved = np.einsum("nij,j->ni", rotation_planar(pose[:, 2]), body[:2])
    return np.column_stack([pose[:, :2] + moved, pose[:, 2] + body[2]])


def world_velocity(twist: Array, heading: Array, body: Array, is_along_world: bool = False) -> Array:
    """Velocity (n, 3) of {b}'s origin in {s}, of twists (n, 3) of the tracked frame, whose heading is (n,): along its
    own axes, or along the world's, where a heading is needed for what is not tracked at {b}'s origin alone."""
    lever = twist[:, 2:] * [-body[1], body[0], 0.0]
    if not is_along_world:
        return np.asarray(np.einsum("nij,nj->ni", body_to_world(heading), twist + lever))
    return twist + np.einsum("nij,nj->ni", body_to_world(heading), lever) if body[:2].any() else twist


def spline_velocity(time: Array, pose: Array, noise: tuple[float, float, float], at: Array, max_gap: float) -> Array:
    """Velocity (len(at), 3) from poses (n, 3) at times (n,); NaN outside stretches of eight poses without a gap."""
    present = np.isfinite(pose).all(axis=1)
    time, pose = time[present], pose[present]
    found = np.full((len(at), 3), np.nan)
    for part in stretches(time, max_gap):
        if part.stop - part.start < MIN_SPLINE_SAMPLES:
            continue
        rows = (at >= time[part.start]) & (at <= time[part.stop - 1])
        for k in range(3):
            found[rows, k] = spline_at_noise(time[part], pose[part, k], noise[k])(at[rows], 1)
    return found
