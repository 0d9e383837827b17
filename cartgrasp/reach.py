"""Where an arm's hand can be: half-spaces on contact points in {b}, `normals @ p <= offsets`, a box among them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from .checks import MAX_NUMBER, numbers
from .contacts import ContactSet, Segment
from .errors import UsageError
from .frames import Array


@dataclass(frozen=True, eq=False)
class Reach:
    """The points p (3,) of {b} with `normals @ p <= offsets`; normals (k, 3) of length 1 (they are made so),
    offsets (k,) in m."""

    normals: Array
    offsets: Array

    def __post_init__(self) -> None:
        try:
            normals, offsets = np.array(self.normals, dtype=float), np.array(self.offsets, dtype=float)
        except (TypeError, ValueError) as error:
            raise UsageError("reach: normals or offsets are no numbers; write Reach.box(low, high)") from error
        if normals.ndim != 2 or normals.shape[1] != 3 or offsets.shape != (len(normals),):
            raise UsageError(f"reach: normals {normals.shape} and offsets {offsets.shape} are not (k, 3) and (k,)")
        with np.errstate(over="ignore"):
            lengths = np.linalg.norm(normals, axis=1)
        if not (np.isfinite(lengths).all() and np.isfinite(offsets).all() and (lengths > 0).all()):
            raise UsageError("reach: a normal or an offset is not finite, or a normal is zero")
        for field, values in (("normals", normals / lengths[:, None]), ("offsets", offsets / lengths)):
            values.setflags(write=False)
            object.__setattr__(self, field, values)

    @classmethod
    def box(cls, low: Sequence[float], high: Sequence[float]) -> Self:
        """All points between two corners (x, y, z) in {b}, m."""
        low, high = (numbers("reach", corner, "(x, y, z) in {b}, m", -MAX_NUMBER) for corner in (low, high))
        if not np.all(np.asarray(low) <= np.asarray(high)):
            raise UsageError(f"reach: {list(low)} and {list(high)} are not the lowest and the highest corner of a box")
        return cls(np.vstack([np.eye(3), -np.eye(3)]), np.concatenate([high, -np.asarray(low, dtype=float)]))

    def excess(self, points: ArrayLike) -> Array:
        """By how much points (..., 3) are out of reach of the worst half-space, m; negative within."""
        return np.asarray((np.asarray(points) @ self.normals.T - self.offsets).max(axis=-1, initial=-np.inf))

    def clip(self, contacts: ContactSet) -> ContactSet | None:
        """What is left of the points and segments; None if nothing is."""
        points = tuple(point for point in contacts.points if self.excess(point) <= 0)
        segments = tuple(part for s in contacts.segments if (part := self._part(s)) is not None)
        return ContactSet(points, segments) if points or segments else None

    def _part(self, segment: Segment) -> Segment | None:
        start, along = np.array(segment.start), np.array(segment.stop) - np.array(segment.start)
        low, high = 0.0, 1.0
        for slope, room in zip(self.normals @ along, self.offsets - self.normals @ start, strict=True):
            if slope == 0 and room < 0:
                return None
            low, high = (max(low, room / slope), high) if slope < 0 else (low, min(high, room / slope if slope else 1))
        if low > high:
            return None
        ends = (segment.at(float(s)).tolist() for s in (low, high))
        first, last = ((x, y, z) for x, y, z in ends)
        return Segment(first if low > 0 else segment.start, last if high < 1 else segment.stop)
