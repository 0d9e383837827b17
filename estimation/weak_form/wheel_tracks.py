"""Where wheels go on the floor, and which regions of it they meet."""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array, rotation_planar
from cartgrasp.wheels import WheelSet


def wheel_tracks(pose: Array, wheels: WheelSet) -> Array:
    """Places (2, w, n) of wheels along poses (n, 3) of {b}, m of {s}."""
    turned = np.moveaxis(rotation_planar(pose[:, 2]), 0, -1)
    return np.asarray(pose.T[:2, None] + np.einsum("ijn,wj->iwn", turned, wheels.positions))


def touches(pose: Array, region: Array, wheels: WheelSet, rim: float = 0.0) -> np.ndarray:
    """Whether (n,) a wheel is inside of a region (x, x, y, y) of the floor, or nearer to it than a rim (m)."""
    return np.asarray(_inside(pose, region, wheels, rim).any(axis=0))


def leaves(pose: Array, region: Array, wheels: WheelSet) -> np.ndarray:
    """Whether (n,) a wheel is outside of a region (x, x, y, y) of the floor."""
    return np.asarray(~_inside(pose, region, wheels, 0.0).all(axis=0))


def _inside(pose: Array, region: Array, wheels: WheelSet, rim: float) -> np.ndarray:
    left, right, low, high = region + rim * np.array([-1.0, 1.0, -1.0, 1.0])
    x, y = wheel_tracks(pose, wheels)
    return np.asarray((x > left) & (x < right) & (y > low) & (y < high))
