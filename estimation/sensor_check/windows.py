"""Windows over a log's own samples: quartic B-splines against which signals are integrated, nothing differentiated.

    ∫ phi g dx,    ∫ phi(t - lag) g dt    and    -∫ phi'(t - lag) g dt

are sums over the intervals between samples, at their middles, so times need not be even. Balances have the same on a
grid (`weak_form`), once poses and velocities are one motion; here they are compared before.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ..weak_form.splines import SPLINE_DEGREE, SplineBasis
from .jumps import jump_times

WINDOW_WIDTH = 0.8
"""s, of a window; starts and stops of carts take about as long."""
MIN_WINDOW_INTERVALS = 12
"""Intervals within a window, at least, for the sums to be integrals."""
MAX_SAMPLE_INTERVAL, COVERAGE_TOLERANCE = WINDOW_WIDTH / 5, 0.005
"""s between samples, from which on nobody knows what happened: from knot to knot. Of a window: how much the sum of its
values may be off, where samples are missing at its ends."""
MIN_WINDOWS, MAX_WINDOWS = 8, 10_000_000
"""Windows: more are of a clock that jumped."""


@dataclass(frozen=True)
class Track:
    """Times (n,), places (n,) and headings (n,), unwrapped, of a log's rows that have a whole pose. Where poses jump
    there is a hole: no way leads across."""

    time: Array
    x: Array
    y: Array
    heading: Array

    @classmethod
    def of(cls, log: RunLog, factor: float = 1.0) -> Track:
        """The track of a log, with headings times a factor."""
        there = np.isfinite(log.pose).all(axis=1)
        for time in jump_times(log):
            there &= np.abs(log.time - time) > MAX_SAMPLE_INTERVAL / 2
        x, y, heading = log.pose[there].T
        return cls(log.time[there], x, y, np.unwrap(factor * heading))


@dataclass(frozen=True)
class Sums:
    """Sums over samples at times (n,), by windows' values and slopes (k, n - 1) at the middles of intervals; which
    windows (k,) samples cover."""

    step: Array
    value: csr_array
    slope: csr_array
    covered: np.ndarray

    def integral(self, signal: Array) -> Array:
        """∫ phi g dt (k, ...) of g (n, ...)."""
        return np.asarray(self.value @ (_middles(signal).T * self.step).T)

    def rate(self, signal: Array) -> Array:
        """∫ phi g' dt (k, ...)."""
        return np.asarray(-(self.slope @ (_middles(signal).T * self.step).T))

    def rate_noise(self, kept: np.ndarray) -> float:
        """How much white noise of variance 1 adds to the sum of squares of the rates that are kept."""
        return float((self.slope.power(2) @ self.step**2)[kept].sum())

    def along(self, position: Array, factor: Array | None = None) -> Array:
        """∫ phi g dx (k,) of x and g (n,), 1 if not given; wherever x is."""
        step = np.diff(position)
        return np.asarray(self.value @ (step if factor is None else _middles(factor) * step))


@dataclass(frozen=True)
class Windows:
    """Windows from the first to the last time (s), with knots `step` (s) apart."""

    first: float
    last: float
    step: float

    @classmethod
    def over(cls, *times: Array) -> Windows | None:
        """The windows over sensors that were sampled at these times; None where that is too short or too slow."""
        if min(len(time) for time in times) < 2 * MIN_WINDOW_INTERVALS:
            return None
        slowest = max(float(np.median(np.diff(time))) for time in times)
        first, last = max(float(t[0]) for t in times), min(float(t[-1]) for t in times)
        found = cls(first, last, WINDOW_WIDTH / (SPLINE_DEGREE + 1))
        is_whole = (MIN_WINDOWS + SPLINE_DEGREE) * found.step < last - first < MAX_WINDOWS * found.step
        return found if slowest * MIN_WINDOW_INTERVALS <= 2 * WINDOW_WIDTH and is_whole else None

    @cached_property
    def basis(self) -> SplineBasis:
        return SplineBasis(self.first, self.step, int((self.last - self.first) / self.step) + SPLINE_DEGREE)

    def on(self, time: Array, late: float = 0.0) -> Sums:
        """The windows' sums over samples at times (n,), each taken `late` s after what it tells."""
        basis, steps, middle = self.basis, np.diff(time), _middles(time) - late
        inside = (middle >= self.first) & (middle <= self.first + self.step * (basis.count - SPLINE_DEGREE))
        whole = slice(SPLINE_DEGREE, basis.count - SPLINE_DEGREE)
        value, slope = (_spread(basis.design(middle[inside], k), inside, whole) for k in (0, 1))
        has_hole = value @ (steps > MAX_SAMPLE_INTERVAL).astype(float) > 0
        covered = ~has_hole & (np.abs(value @ steps / self.step - 1) < COVERAGE_TOLERANCE)
        return Sums(steps, value, slope, np.asarray(covered))


def _spread(design: csr_array, inside: np.ndarray, whole: slice) -> csr_array:
    """The whole windows of a design (m, k), which is at the middles that are inside, as rows over all middles."""
    rows = csr_array(design[:, whole].T)
    at = np.flatnonzero(inside)
    return csr_array((rows.data, at[rows.indices], rows.indptr), shape=(rows.shape[0], len(inside)))


def _middles(signal: Array) -> Array:
    return np.asarray((signal[1:] + signal[:-1]) / 2)
