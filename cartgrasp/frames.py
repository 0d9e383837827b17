"""Planar and spatial frames: rotations, adjoints, angles.

Planar order is (vx, vy, omega) and (fx, fy, tau); spatial wrenches are force first, (fx, fy, fz, tx, ty, tz).
Adjacent letters cancel: `pose_sb` is the pose of {b} in {s}, and `adjoint(g_ab) @ twist_b` is the twist in {a}.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
PLANAR = (0, 1, 5)
"""Places of (fx, fy, tau), or (vx, vy, omega), among the six of a spatial wrench or twist."""


def wrap_angle(angle: ArrayLike) -> Array:
    """The same angle in [-pi, pi)."""
    wrapped = (np.asarray(angle, dtype=float) + np.pi) % (2 * np.pi) - np.pi
    return np.where(wrapped < np.pi, wrapped, -np.pi)  # a hair below -pi is rounded to pi


def unwrapped(angles: Array, period: float = 2 * np.pi) -> Array:
    """Angles (n,) without jumps of a turn, over those that are there: NaN stay."""
    found, there = np.array(angles, dtype=float), np.isfinite(angles)
    found[there] = np.unwrap(found[there], period=period)
    return found


def rotation_planar(angle: ArrayLike) -> Array:
    """Planar rotation, shape (..., 2, 2)."""
    angle = np.asarray(angle, dtype=float)
    rotation = np.empty((*angle.shape, 2, 2))
    rotation[..., 0, 0] = rotation[..., 1, 1] = np.cos(angle)
    rotation[..., 1, 0] = np.sin(angle)
    rotation[..., 0, 1] = -rotation[..., 1, 0]
    return rotation


def body_to_world(theta: ArrayLike) -> Array:
    """R(theta) on planar twists and wrenches, shape (..., 3, 3): world components from body components."""
    theta = np.asarray(theta, dtype=float)
    rotation = np.zeros((*theta.shape, 3, 3))
    rotation[..., :2, :2] = rotation_planar(theta)
    rotation[..., 2, 2] = 1.0
    return rotation


def rotation_z(angle: float) -> Array:
    """Spatial rotation about z, shape (3, 3)."""
    rotation = np.eye(3)
    rotation[:2, :2] = rotation_planar(angle)
    return rotation


def components(vector: Array) -> tuple[Array, ...]:
    """The entries along the last axis, each (...)."""
    return tuple(vector[..., i] for i in range(vector.shape[-1]))


def skew(vector: ArrayLike) -> Array:
    """[p]x with `skew(p) @ q == cross(p, q)`, shape (..., 3, 3)."""
    x, y, z = components(np.asarray(vector, dtype=float))
    zero = np.zeros_like(x)
    return np.stack([np.stack([zero, -z, y], -1), np.stack([z, zero, -x], -1), np.stack([-y, x, zero], -1)], -2)


def adjoint(rotation: ArrayLike, position: ArrayLike) -> Array:
    """Ad_g = [[R, [p]x R], [0, R]] of (23), on spatial twists with the linear part first, shape (..., 6, 6)."""
    rotation, position = np.asarray(rotation, dtype=float), np.asarray(position, dtype=float)
    result = np.zeros((*np.broadcast_shapes(rotation.shape[:-2], position.shape[:-1]), 6, 6))
    result[..., :3, :3] = result[..., 3:, 3:] = rotation
    result[..., :3, 3:] = skew(position) @ rotation
    return result
