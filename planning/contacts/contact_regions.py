"""Where the hands may be: boxes of contacts (one piece of a segment, or one point, for each arm) and the
hands' distance.

A box is `low + s (high - low)` with one s in [0, 1] for each arm. What two moving hands may not do, be nearer
than d, is an ellipse in (s_1, s_2), since ‖p_1 - p_2‖ is convex. The hull of a box without a convex set has
its vertices on the box's edges outside the set: corners, and crossings of edges with the ellipse. Its error
falls with the square of the box's size, and for parallel segments it is none once the box lies on one side.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from cartgrasp.frames import Array

DISTANCE_TOLERANCE = 1e-10  # m


def hand_distance(contacts: Array) -> Array:
    """Least distance between any two hands of contacts (..., n, 3), shape (...); infinite for one hand."""
    n = contacts.shape[-2]
    if n < 2:
        return np.full(contacts.shape[:-2], np.inf)
    one, other = np.triu_indices(n, 1)
    apart = np.linalg.norm(contacts[..., one, :] - contacts[..., other, :], axis=-1)
    return np.asarray(apart.min(axis=-1))


@dataclass(frozen=True, eq=False)
class Box:
    """Contacts of n arms between `low` and `high`, (n, 3) each."""

    low: Array
    high: Array

    @property
    def moving(self) -> NDArray[np.intp]:
        """Indices of the arms that still may move."""
        return np.flatnonzero((self.low != self.high).any(axis=1))

    @property
    def size(self) -> float:
        return float(np.linalg.norm(self.high - self.low, axis=1).max())

    def at(self, s: Array) -> Array:
        """Contacts (..., n, 3) at s (..., n_moving)."""
        full = np.zeros((*s.shape[:-1], len(self.low), 1))
        full[..., self.moving, 0] = s
        return self.low + full * (self.high - self.low)

    def halves(self) -> tuple[Box, Box]:
        """Split across the longest piece."""
        arm = int(np.linalg.norm(self.high - self.low, axis=1).argmax())
        first, second = self.high.copy(), self.low.copy()
        first[arm] = second[arm] = 0.5 * (self.low[arm] + self.high[arm])
        return Box(self.low, first), Box(second, self.high)


@dataclass(frozen=True, eq=False)
class Region:
    """The hull of what a box leaves for hands at least a distance apart: vertices s (k, n_moving), as contacts too."""

    box: Box
    s: Array
    vertices: Array

    @classmethod
    def of(cls, box: Box, distance: float) -> Region | None:
        """None where no contacts of the box keep the distance."""
        moving = box.moving
        s = np.array(list(product((0.0, 1.0), repeat=len(moving)))).reshape(2 ** len(moving), len(moving))
        if distance > 0 and len(moving) <= 2:
            s = np.vstack([s, *_crossings(box, distance)]) if len(moving) == 2 else s
            s = s[hand_distance(box.at(s)) >= distance - DISTANCE_TOLERANCE]
        elif distance > 0 and not _may_keep(box.at(s), distance):
            return None
        return cls(box, s, box.at(s)) if len(s) else None

    def extremes(self) -> list[tuple[int, int]]:
        """Pairs (high, low) of vertices such that, whatever the moment per s is, one pair is its largest and
        smallest."""
        if len(self.s) == 1:
            return [(0, 0)]
        dimensions = self.s.shape[1]
        if dimensions == 2:
            one, other = np.triu_indices(len(self.s), 1)
            sides = self.s[one] - self.s[other]
            turns = np.arctan2(sides[:, 0], -sides[:, 1])
            angles = np.unique(np.concatenate([turns, turns + np.pi]) % (2 * np.pi))
            middles = 0.5 * (angles + np.append(angles[1:], angles[0] + 2 * np.pi))
            directions = np.stack([np.cos(middles), np.sin(middles)], axis=-1)
        else:
            directions = np.array(list(product((-1.0, 1.0), repeat=dimensions)))
        along = directions @ self.s.T
        return sorted(set(zip(along.argmax(axis=1).tolist(), along.argmin(axis=1).tolist(), strict=True)))


def boxes(pieces: Sequence[tuple[Array, Array]], distance: float) -> Iterator[Box]:
    """Boxes of one choice for each arm (a point has equal ends), less what is too near to another arm's point."""
    points = [low for low, high in pieces if (low == high).all()]
    cut = [
        [(low, high)] if (low == high).all() or distance <= 0 else _clear_of(low, high, points, distance)
        for low, high in pieces
    ]
    for combination in product(*cut):
        yield Box(np.array([low for low, _ in combination]), np.array([high for _, high in combination]))


def _clear_of(low: Array, high: Array, points: list[Array], distance: float) -> list[tuple[Array, Array]]:
    """The parts of a segment that are at least `distance` from all points."""
    free = [(0.0, 1.0)]
    for point in points:
        inside = _inside(low - point, high - low, distance)
        if inside is not None:
            free = [part for start, stop in free for part in _without((start, stop), inside)]
    return [(low + start * (high - low), low + stop * (high - low)) for start, stop in free]


def _crossings(box: Box, distance: float) -> list[Array]:
    """Where the edges of a box of two moving arms leave the forbidden ellipse, as s (k, 2)."""
    one, other = box.moving
    found = []
    for mover, fixed, column in ((one, other, 0), (other, one, 1)):
        for end, position in ((0.0, box.low[fixed]), (1.0, box.high[fixed])):
            inside = _inside(box.low[mover] - position, box.high[mover] - box.low[mover], distance)
            if inside is None:
                continue
            s = np.array([[root, end] for root in inside if 0.0 < root < 1.0]).reshape(-1, 2)
            found.append(s if column == 0 else s[:, ::-1])
    return found


def _inside(offset: Array, along: Array, distance: float) -> tuple[float, float] | None:
    """The s with ‖offset + s along‖ < distance, as an open interval; None if there are none."""
    a, b, c = float(along @ along), float(offset @ along), float(offset @ offset) - distance**2
    root = b * b - a * c
    if root <= 0 or a == 0:
        return None
    return (-b - root**0.5) / a, (-b + root**0.5) / a


def _without(part: tuple[float, float], hole: tuple[float, float]) -> list[tuple[float, float]]:
    pieces = [(part[0], min(part[1], hole[0])), (max(part[0], hole[1]), part[1])]
    return [(start, stop) for start, stop in pieces if start <= stop]


def _may_keep(corners: Array, distance: float) -> bool:
    """Whether every pair of arms can be apart at some corner: the distance is convex, so largest at one."""
    one, other = np.triu_indices(corners.shape[-2], 1)
    apart = np.linalg.norm(corners[:, one] - corners[:, other], axis=-1).max(axis=0)
    return bool((apart >= distance - DISTANCE_TOLERANCE).all())
