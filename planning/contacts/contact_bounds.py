"""Candidate contacts of all arms as arrays, and the bounds on every choice among them by the cuts collected so far."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import combinations
from math import prod
from typing import Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from cartgrasp.contacts import ContactSet
from cartgrasp.frames import Array

from ..allocation.allocation_template import AllocationTemplate
from ..allocation.duality import Cut
from .contact_regions import DISTANCE_TOLERANCE

MAX_CUTS_PER_BOX = 32  # cuts tried on a box
MAX_TABLE_CHOICES = 2**16  # choices that one table holds
Scalar = TypeVar("Scalar", bound=np.generic)


@dataclass(frozen=True, eq=False)
class Candidates:
    """Options of every arm. Each is a pair of vertices: a point twice, or the ends of a segment.

    All vertices stand in one array (V, 3), all options in one of pairs (O, 2) into it; arm i has the options
    from `starts[i]` to `starts[i + 1]`.
    """

    vertices: Array
    options: np.ndarray
    starts: tuple[int, ...]
    arm_of_vertex: np.ndarray
    distance: float

    def __post_init__(self) -> None:
        self.vertices.setflags(write=False)  # plans show them

    @classmethod
    def of(cls, contact_sets: Sequence[ContactSet], distance: float = 0.0) -> Self:
        vertices: list[tuple[float, float, float]] = []
        options: list[tuple[int, int]] = []
        starts, owners = [0], list[int]()
        for arm, contacts in enumerate(contact_sets):
            for point in contacts.points:
                options.append((len(vertices), len(vertices)))
                vertices.append(point)
            for segment in contacts.segments:
                options.append((len(vertices), len(vertices) + 1))
                vertices += [segment.start, segment.stop]
            owners += [arm] * (len(vertices) - len(owners))
            starts.append(len(options))
        return cls(np.array(vertices), np.array(options), tuple(starts), np.array(owners), distance)

    @classmethod
    def at(cls, points: Sequence[tuple[float, float, float]], distance: float = 0.0) -> Self:
        """One point (x, y, z) for each arm: no choice."""
        return cls(np.array(points), *_one_each(len(points)), distance)

    def with_point(self, arm: int, point: Array) -> Self:
        """The candidates with one more option `point` (3,) of an arm, as its last."""
        at, new = self.starts[arm + 1], len(self.vertices)
        starts = tuple(start + (i > arm) for i, start in enumerate(self.starts))
        return replace(
            self,
            vertices=np.vstack([self.vertices, point]),
            options=np.insert(self.options, at, (new, new), axis=0),
            starts=starts,
            arm_of_vertex=np.append(self.arm_of_vertex, arm),
        )

    @property
    def n_arms(self) -> int:
        return len(self.starts) - 1

    @cached_property
    def ends(self) -> Array:
        """The two ends of each option, (O, 2, 3)."""
        return np.asarray(self.vertices[self.options])

    @property
    def count(self) -> int:
        """Number of full choices, a segment counted once."""
        return prod(stop - start for start, stop in zip(self.starts, self.starts[1:], strict=False))

    @property
    def has_segments(self) -> bool:
        return len(self.vertices) > len(self.options)

    @cached_property
    def single(self) -> Array | None:
        """The contacts (n, 3) if there is only one choice, and that of points; else None."""
        return self.vertices if len(self.vertices) == len(self.options) == self.n_arms else None

    @property
    def first(self) -> Array:
        """The first end of each arm's first option, (n, 3)."""
        return np.asarray(self.vertices[self.options[list(self.starts[:-1]), 0]])

    @cached_property
    def reach(self) -> Array:
        """Largest distance between a pair of options, (O, O): at their ends, since distance is convex."""
        apart = np.linalg.norm(self.vertices[:, None] - self.vertices, axis=-1)
        ends = self.options.T
        return np.asarray(np.max([apart[np.ix_(one, other)] for one in ends for other in ends], axis=0))

    @cached_property
    def widest(self) -> float:
        """An upper bound of the hands' distance over all choices; for points (and up to 2^16 choices) the largest."""
        if self.single is not None:
            return min((math.dist(p, q) for p, q in combinations(self.vertices.tolist(), 2)), default=np.inf)
        pairs = [(i, j) for j in range(self.n_arms) for i in range(j)]
        slices = [slice(a, b) for a, b in zip(self.starts, self.starts[1:], strict=False)]
        if self.count > MAX_TABLE_CHOICES:
            return min((float(self.reach[slices[i], slices[j]].max()) for i, j in pairs), default=np.inf)
        least = np.full([part.stop - part.start for part in slices], np.inf)
        for i, j in pairs:
            least = np.minimum(least, _along(self.reach[slices[i], slices[j]], (i, j), self.n_arms))
        return float(least.max())

    def pieces(self, choice: Sequence[int]) -> list[tuple[Array, Array]]:
        """Ends of the chosen options, counted within each arm."""
        ends = self.vertices[self.options[[start + c for start, c in zip(self.starts, choice, strict=False)]]]
        return [(low, high) for low, high in ends]

    def allowed(self, choice: Sequence[int], arms: Sequence[int]) -> NDArray[np.bool_]:
        """Which options of the next `arms` can keep the distance to what is chosen and to each other, shape
        (o, o, …)."""
        slices = [slice(self.starts[arm], self.starts[arm + 1]) for arm in arms]
        fits = np.ones([part.stop - part.start for part in slices], dtype=bool)
        if self.distance <= 0:
            return fits
        near = self.reach < self.distance - DISTANCE_TOLERANCE
        chosen = [self.starts[i] + c for i, c in enumerate(choice)]
        for i, part in enumerate(slices):
            fits &= _along(np.asarray(~near[chosen, part].any(axis=0)), (i,), len(slices))
            for j, other in enumerate(slices[:i]):
                fits &= _along(~near[other, part], (j, i), len(slices))
        return fits


@dataclass(eq=False)
class ChoiceTable:
    """Bounds of the ways (o, o, …) to go on from a choice for the first arms; those taken are infinite."""

    choice: tuple[int, ...]
    bounds: Array
    n_cuts: int = 0

    @property
    def least(self) -> float:
        return float(self.bounds.min())

    def take(self) -> tuple[int, ...]:
        """The choice of least bound, which leaves the table."""
        index = np.unravel_index(int(self.bounds.argmin()), self.bounds.shape)
        self.bounds[index] = np.inf
        return (*self.choice, *(int(i) for i in index))


class CutPool:
    """Cuts, tabulated over the candidates: a bound of a choice is a sum over arms, the best over cuts. `charges` (O,)
    are what options cost beside the effort."""

    def __init__(
        self, candidates: Candidates, template: AllocationTemplate, ray_tolerance: float, charges: Array | None = None
    ) -> None:
        self._candidates, self._template, self._ray_tolerance = candidates, template, ray_tolerance
        self._charges = charges
        self._rows = template.contact_rows(candidates.vertices, candidates.arm_of_vertex)
        self._cuts: list[Cut] = []
        self._tables = np.zeros((8, len(candidates.options)))
        self._least = np.zeros((8, candidates.n_arms))
        self._constants = np.zeros(8)
        self._rays = np.zeros(8, dtype=bool)

    def add(self, cut: Cut) -> None:
        k = len(self._cuts)
        if k == len(self._constants):
            self._tables, self._least = (np.concatenate([a, a]) for a in (self._tables, self._least))
            self._constants, self._rays = (np.concatenate([a, a]) for a in (self._constants, self._rays))
        self._cuts.append(cut)
        by_vertex = cut.per_vertex(self._rows, self._candidates.arm_of_vertex)
        self._tables[k] = by_vertex[self._candidates.options].min(axis=1)
        if self._charges is not None and not cut.ray:
            self._tables[k] += self._charges
        self._least[k] = np.minimum.reduceat(self._tables[k], self._candidates.starts[:-1])
        self._constants[k], self._rays[k] = cut.constant, cut.ray

    def children(self, choice: Sequence[int], n_next: int) -> ChoiceTable:
        """A choice with every way to choose for the next `n_next` arms."""
        arms = range(len(choice), len(choice) + n_next)
        allowed = self._candidates.allowed(choice, arms)
        return ChoiceTable(tuple(choice), np.where(allowed, -np.inf, np.inf))

    def refresh(self, table: ChoiceTable) -> None:
        """Raises a table's bounds by the cuts that came since."""
        n_next, start, sums = table.bounds.ndim, len(table.choice), self._sum(table.choice)
        for cut in range(table.n_cuts, len(self._cuts)):
            values = sums[cut]
            for i, arm in enumerate(range(start, start + n_next)):
                options = slice(self._candidates.starts[arm], self._candidates.starts[arm + 1])
                values = values + _along(self._tables[cut, options] - self._least[cut, arm], (i,), n_next)
            if self._rays[cut]:
                table.bounds[values > self._ray_tolerance] = np.inf
            else:
                np.maximum(table.bounds, values, out=table.bounds)
        table.n_cuts = len(self._cuts)

    def at(self, high: Array, low: Array) -> Array:
        """Bounds (c,) by recent cuts for cases (c, n, 3), without what options cost. A range of contacts is bounded
        where a cut is least."""
        rows = self._template.contact_rows(np.stack([high, low]))
        recent = range(max(0, len(self._cuts) - MAX_CUTS_PER_BOX), len(self._cuts))
        values = [self._cuts[i].value(rows[int(self._cuts[i].looks_low)]) for i in recent]
        return self._best(np.array(values).reshape(len(values), len(high)), recent.start)

    def _sum(self, choice: Sequence[int]) -> Array:
        k = len(self._cuts)
        chosen = [self._candidates.starts[i] + c for i, c in enumerate(choice)]
        free = self._least[:k, len(choice) :].sum(axis=1)
        return np.asarray(self._constants[:k] + self._tables[:k, chosen].sum(axis=1) + free)

    def _best(self, values: Array, start: int) -> Array:
        """Highest bound over cuts (k, c) from `start`; infinite where a ray proves that nothing is feasible."""
        rays = self._rays[start : start + len(values)]
        best = values[~rays].max(axis=0, initial=-np.inf)
        return np.where((values[rays] > self._ray_tolerance).any(axis=0), np.inf, best)


@cache
def _one_each(n: int) -> tuple[np.ndarray, tuple[int, ...], np.ndarray]:
    """Options, starts and owners of one point for each arm."""
    arms = np.arange(n)
    return arms[:, None].repeat(2, axis=1), tuple(range(n + 1)), arms


def _along(values: NDArray[Scalar], axes: tuple[int, ...], n: int) -> NDArray[Scalar]:
    """Values of a few axes among n, ready to broadcast."""
    return values.reshape([values.shape[axes.index(i)] if i in axes else 1 for i in range(n)])
