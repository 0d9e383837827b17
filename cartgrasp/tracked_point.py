"""From the frame {t} that a tracker follows to {b}, and back: `pose_tb` (3,) is where {b} is in it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from .frames import Array, rotation_planar
from .motion import Measurement


def composed(pose_sa: Array, pose_ab: Array) -> Array:
    """`pose_sb`, (..., 3). A heading that is not known (NaN) is asked for only where {b}'s origin is not {a}'s."""
    heading, place = pose_sa[..., 2], pose_ab[..., :2]
    shift = rotation_planar(heading) @ place if np.any(place) else 0.0
    return np.concatenate([pose_sa[..., :2] + shift, (heading + pose_ab[..., 2])[..., None]], axis=-1)


def inverted(pose_ab: Array) -> Array:
    """`pose_ba`, (3,)."""
    return np.append(-rotation_planar(pose_ab[2]).T @ pose_ab[:2], -pose_ab[2])


def carried(velocity_s: Array, heading: Array, place_a: Array) -> Array:
    """Velocities (..., 3) in {s} of a point at `place_a` (2,) of a frame with such headings (...) and velocities."""
    if not np.any(place_a):
        return velocity_s
    x, y = np.moveaxis(rotation_planar(heading) @ place_a, -1, 0)
    turn = velocity_s[..., 2]
    return np.asarray(velocity_s + np.stack([-turn * y, turn * x, np.zeros_like(turn)], axis=-1))


def in_frame(pose_ab: Array) -> Array:
    """What takes twists (u, w, r) of a body in its frame {a} to those in its frame {b}, (3, 3)."""
    back = rotation_planar(pose_ab[2]).T
    found = np.eye(3)
    found[:2, :2] = back
    found[:2, 2] = back @ [-pose_ab[1], pose_ab[0]]
    return found


class TrackedPoint:
    """Brings measurements to {b}: velocities that come alone by the newest heading that was seen, and how far the cart
    has turned since."""

    def __init__(self, pose_tb: Array) -> None:
        self.pose_tb, self._is_body = pose_tb, not pose_tb.any()
        self._time, self._heading = math.nan, math.nan

    def at_body(self, measurement: Measurement) -> Measurement:
        if self._is_body:
            return measurement
        pose, velocity, time = measurement.pose, measurement.velocity, measurement.time
        seen_at, heading = self._time, self._heading
        if pose is not None and math.isfinite(pose[2]):
            seen_at, heading = time, float(pose[2])
            if not time < self._time:
                self._time, self._heading = seen_at, heading
        if velocity is not None:
            turned = np.nan_to_num(velocity[2]) * (time - seen_at)
            velocity = carried(np.asarray(velocity, dtype=float), heading + turned, self.pose_tb[:2])
        pose = None if pose is None else composed(np.asarray(pose, dtype=float), self.pose_tb)
        return replace(measurement, pose=pose, velocity=velocity)
