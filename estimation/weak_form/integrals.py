"""Integrals of signals against test functions: cubic B-splines over a grid of times, a row step apart."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_array

from cartgrasp.frames import Array

SPLINE_SUPPORT = 4
"""Row steps over which a cubic B-spline is not zero."""
GRID_CHUNK_POINTS = 20_000
"""Points of the grid that are worked out at once: an hour's partials would take gigabytes."""
GRID_STRIDE = 2
"""Points of the grid from one to the next at which candidates are worked out: five in a row's step at least."""


@dataclass(frozen=True, eq=False)
class Integrals:
    """Test functions on a grid, a row each (k, n), times the grid's `step` (s). `used` (k,) are their numbers among all
    that are `per_row` points apart."""

    test: csr_array
    used: np.ndarray
    per_row: int
    step: float

    @classmethod
    def where(cls, unseen: np.ndarray, moves: np.ndarray, per_row: int, step: float) -> Integrals:
        """Integrals against test functions in whose support nothing is unseen and something moves (n,). Where there are
        none, those in which nothing is unseen are used."""
        test = _test_functions(len(unseen), per_row, step)
        touches = csr_array((np.ones_like(test.data), test.indices, test.indptr), shape=test.shape)
        seen, moving = touches @ unseen.astype(float) == 0, touches @ moves.astype(float) > 0
        used = np.flatnonzero(seen & moving if (seen & moving).any() else seen)
        return cls(csr_array(test[used]), used, per_row, step)

    @property
    def middles(self) -> np.ndarray:
        """Middles (k,) of the test functions, as points of the grid."""
        return self.per_row * self.used + SPLINE_SUPPORT * self.per_row // 2

    def of(self, signals: Array) -> Array:
        """Integrals (k, ...) of signals (n, ...) against the test functions."""
        return _against(self.test, signals)

    def by_parts(self, signals: Callable[[slice], Array], is_thin: bool = False) -> Array:
        """Integrals of signals that are worked out for one part of the grid after the other, or at every other of its
        points (`is_thin`)."""
        parts = self._thin_parts if is_thin else self._parts
        found = [_against(test, signals(part)) for part, test in parts]
        return np.concatenate(found) if found else self.of(signals(slice(None)))

    def spread(self, rows: Array) -> Array:
        """The transpose of `of`: rows (k, c) over the grid (n, c)."""
        return np.asarray(self.test.T @ rows)

    def overlap(self, order: int, lag: int) -> float:
        """Integral of a test function's derivative of some order times that of the one `lag` rows later (1/s^(2 order -
        1))."""
        return _overlap(order, lag) * (self.per_row * self.step) ** (1 - 2 * order)

    @cached_property
    def _parts(self) -> list[tuple[slice, csr_array]]:
        """Parts of the grid, and test functions (rows, points) of those rows that lie in them."""
        found, first = [], self.per_row * self.used
        support = SPLINE_SUPPORT * self.per_row + 1
        edges = np.flatnonzero(np.diff(first // max(GRID_CHUNK_POINTS - support, support), prepend=-1))
        for begin, end in pairwise([*edges, len(first)]):
            part = slice(int(first[begin]) // GRID_STRIDE * GRID_STRIDE, int(first[end - 1]) + support)
            found.append((part, csr_array(self.test[begin:end][:, part])))
        return found

    @cached_property
    def _thin_parts(self) -> list[tuple[slice, csr_array]]:
        """Parts of the grid and test functions, at every other point."""
        thinned = (slice(part.start, part.stop, GRID_STRIDE) for part, _ in self._parts)
        return [
            (part, csr_array(test[:, ::GRID_STRIDE] * GRID_STRIDE))
            for part, (_, test) in zip(thinned, self._parts, strict=True)
        ]


def _test_functions(n: int, per_row: int, step: float) -> csr_array:
    count = max((n - 1 - SPLINE_SUPPORT * per_row) // per_row + 1, 0)
    inside = np.arange(SPLINE_SUPPORT * per_row + 1) / per_row
    phi = np.nan_to_num(BSpline.basis_element(np.arange(SPLINE_SUPPORT + 1.0), extrapolate=False)(inside)) * step
    first = per_row * np.arange(count)
    columns = (first[:, None] + np.arange(len(phi))).ravel()
    return csr_array((np.tile(phi, count), columns, len(phi) * np.arange(count + 1)), shape=(count, n))


def _against(test: csr_array, signals: Array) -> Array:
    return np.asarray(test @ signals.reshape(len(signals), -1)).reshape(-1, *signals.shape[1:])


@lru_cache
def _overlap(order: int, lag: int) -> float:
    """The integral in `Integrals.overlap`, of test functions one second apart."""
    inside = np.linspace(0.0, SPLINE_SUPPORT, 40 * SPLINE_SUPPORT + 1)
    element = BSpline.basis_element(np.arange(SPLINE_SUPPORT + 1.0), extrapolate=False)
    one = np.nan_to_num((element.derivative(order) if order else element)(inside))
    other = np.zeros_like(one)
    other[40 * lag :] = one[: len(one) - 40 * lag]
    return float(np.trapezoid(one * other, inside))
