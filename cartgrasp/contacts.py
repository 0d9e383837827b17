"""Where arms hold the cart, and the grasp map from contact wrenches to the cart's wrench.

A contact frame {a} sits at a point of {b}, turned about z by a yaw. Its spatial wrench `F_a` becomes the cart's
`wrench_b = (fx, fy, tau)` by the planar grasp map `G_ba = Bᵀ Ad_{g_ab}ᵀ`, 3 x 6, which for parallel axes is
`[1 0 0 0 0 0; 0 1 0 0 0 0; -py px 0 0 0 1]` (physics.md, correcting (22)-(24)).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .checks import MAX_DISTANCE, check_kind, listed, numbers, shown
from .errors import UsageError
from .frames import Array, adjoint, body_to_world

MAX_POSITION = MAX_DISTANCE
WRENCH_NAMES = ("fx", "fy", "fz", "tx", "ty", "tz")


def points_of(what: str, points: Any) -> tuple[tuple[float, float, float], ...]:
    """Contact points in {b}, as numbers."""
    if isinstance(points, str) or not isinstance(points, Iterable):
        raise UsageError(f"{what}: {shown(points)} is no list of points; write [(x, y, z)], in m")
    low, high, found = -MAX_POSITION, MAX_POSITION, []
    for point in points:
        if isinstance(point, float | int):
            raise UsageError(f"{what}: {shown(points)} is one point; a list of points is needed: [(x, y, z)]")
        found.append(numbers(what, point, "(x, y, z) in {b}, m", low, high))
    return tuple((x, y, z) for x, y, z in found)


def grasp_map_spatial(position_b: ArrayLike, yaw: ArrayLike = 0.0) -> Array:
    """Ad_{g_ab}ᵀ, shape (..., 6, 6), of contact points (..., 3) and yaws (...): `wrench6_b = G @ wrench6_a`."""
    rotation_ab = np.swapaxes(body_to_world(yaw), -1, -2)  # of (x, y, 0), so about z as well
    position_a = -(rotation_ab @ np.asarray(position_b, dtype=float)[..., None])[..., 0]
    return np.swapaxes(adjoint(rotation_ab, position_a), -1, -2)


def grasp_map_planar(position_b: ArrayLike, yaw: ArrayLike = 0.0) -> Array:
    """G_ba, shape (..., 3, 6), of contact points (..., 3) in {b} and yaws (...)."""
    position = np.asarray(position_b, dtype=float)
    x, y = position[..., 0], position[..., 1]
    c, s = np.cos(yaw), np.sin(yaw)
    grasp_map = np.zeros((*np.broadcast_shapes(x.shape, np.shape(c)), 3, 6))
    grasp_map[..., 0, 0], grasp_map[..., 0, 1] = c, -s
    grasp_map[..., 1, 0], grasp_map[..., 1, 1] = s, c
    grasp_map[..., 2, 0] = x * s - y * c
    grasp_map[..., 2, 1] = x * c + y * s
    grasp_map[..., 2, 5] = 1.0
    return grasp_map


@dataclass(frozen=True)
class Segment:
    """All points between two ends in {b}: a handle."""

    start: tuple[float, float, float]
    stop: tuple[float, float, float]

    def __post_init__(self) -> None:
        points_of("segment", (self.start, self.stop))

    def at(self, fraction: float) -> Array:
        start, stop = np.array(self.start), np.array(self.stop)
        return np.asarray(start + fraction * (stop - start))


@dataclass(frozen=True)
class ContactSet:
    """Where an arm may hold: points and segments in {b}, m."""

    points: tuple[tuple[float, float, float], ...] = ()
    segments: tuple[Segment, ...] = ()

    def __post_init__(self) -> None:
        if not self.points and not self.segments:
            raise UsageError("contacts: none given; an arm needs a point or a segment to hold")
        points_of("contacts", self.points)
        listed("contacts: segments", self.segments, Segment, "write [Segment(start, stop)]")

    @property
    def first(self) -> Array:
        """The first candidate: a point, or the middle of a segment."""
        return np.array(self.points[0]) if self.points else self.segments[0].at(0.5)


@dataclass(frozen=True)
class ContactWrenches:
    """What each arm gives to the cart: wrench (6,) in its contact frame {a}, at a point (3,) of {b}. Arms that are
    `away` hold nothing: their wrench is zero, which needs no sensor, and their point is where the hand is."""

    wrenches: Mapping[str, Array] = field(default_factory=dict)
    contacts: Mapping[str, Array] = field(default_factory=dict)
    yaws: Mapping[str, float] = field(default_factory=dict)
    away: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        for name, parts, n in (("wrenches", self.wrenches, 6), ("contacts", self.contacts, 3)):
            check_kind(name, parts, Mapping, "write {arm: numbers}")
            for arm, part in parts.items():
                if np.shape(part) != (n,):
                    raise UsageError(f"{name}: {arm}: shape {np.shape(part)} instead of {n} numbers")
        if set(self.wrenches) != set(self.contacts):
            raise UsageError(
                f"wrenches of {sorted(self.wrenches)} but contacts of {sorted(self.contacts)}: name the same arms"
            )

    def grasp_map_ba(self, arm: str) -> Array:
        return grasp_map_planar(self.contacts[arm], self.yaws.get(arm, 0.0))

    @property
    def wrench_b(self) -> Array:
        """Sum over arms of `G_ba @ F_a` (25), shape (3,)."""
        total = np.zeros(3)
        for arm, wrench_a in self.wrenches.items():
            total += self.grasp_map_ba(arm) @ wrench_a
        return total

    @property
    def spatial_wrench_b(self) -> Array:
        """All six components of it, about {b}'s origin."""
        total = np.zeros(6)
        for arm, wrench_a in self.wrenches.items():
            total += grasp_map_spatial(self.contacts[arm], self.yaws.get(arm, 0.0)) @ wrench_a
        return total
