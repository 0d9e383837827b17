"""What `WrenchPlanner` has compiled: allocations at given contacts, and choice among this tick's candidates."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import combinations
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.frames import Array

from .allocation_template import AllocationTemplate
from .compiled_allocation import CompiledAllocation, Point
from .compiled_choice import CompiledChoice
from .contact_bounds import Candidates
from .contact_choice import Choice, SearchLimit
from .contact_regions import DISTANCE_TOLERANCE
from .objectives import Cost


class CompiledPlanning:
    def __init__(self, allocation: CompiledAllocation, template: AllocationTemplate, candidates: Candidates) -> None:
        self.allocation, self._names = allocation, template.names
        self._distance = candidates.distance
        self._own_points = None if candidates.single is None or self._too_near(candidates.single) else candidates.single
        self._given, self._given_points = b"", candidates.vertices
        self._candidates: Candidates | None = None
        self._choice: CompiledChoice | None = None

    @classmethod
    def of(cls, template: AllocationTemplate, cost: Cost, candidates: Candidates) -> Self | None:
        """None where the general road is needed for every program."""
        allocation = CompiledAllocation.of(template, cost)
        return None if allocation is None else cls(allocation, template, candidates)

    def points(self, contacts: Mapping[str, ArrayLike] | None) -> Array | None:
        """The arms' contacts (n, 3), the same object as long as they are the same; None if some are to be chosen, or
        if there is something to refuse, which is for the general road to say."""
        if contacts is None:
            return self._own_points
        try:
            points = np.array([contacts[name] for name in self._names], dtype=float)
        except (KeyError, TypeError, ValueError, OverflowError):
            return None
        given = points.tobytes()
        if given != self._given:
            if points.shape != (len(self._names), 3) or len(contacts) > len(points) or self._too_near(points):
                return None
            self._given, self._given_points = given, points
        return self._given_points

    def choose(self, wrench: Point, candidates: Candidates, cost: Cost, limit: SearchLimit) -> Choice | None:
        """The allocation then holds the answer at the contacts chosen. None if this is for the general search."""
        if candidates is not self._candidates:
            self._candidates, self._choice = candidates, CompiledChoice.of(candidates, self.allocation)
        return None if self._choice is None else self._choice.run(wrench, cost, limit)

    def forget(self) -> None:
        """The next search begins as if it were the first."""
        self._candidates = None

    def _too_near(self, points: Array) -> bool:
        if self._distance <= 0:
            return False
        pairs = combinations(points.tolist(), 2)
        return min((math.dist(p, q) for p, q in pairs), default=math.inf) < self._distance - DISTANCE_TOLERANCE
