"""Test functions: smooth bumps against which signals are integrated, so that nothing is differentiated.

With phi(t) = (1 - s²)⁴, s = (t - centre) / half width, which is 0 with three derivatives at both ends,

    ∫ phi g dx   and   ∫ phi g d(dx/dt) = -∫ (phi g)' dx

hold samples of x alone; sums over the intervals between samples take phi at their middles, so times need not be even.
Noise of x that is white averages out in either. See also Gurevich, Reinbold, Grigoriev, "Robust and optimal sparse
regression for nonlinear PDE models", 2019.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from cartgrasp.frames import Array

POWER = 4
"""Of the bump: three derivatives are 0 at its ends, so that sums over even steps err by their fourth power only."""
OVERLAP = 4
"""Bumps that reach over one instant: half of the information that more would add is there from two on."""
COVERED = 8.0
"""No interval between samples is longer than the width over this: a hole in a window is no measurement."""


@dataclass(frozen=True)
class Sums:
    """Of samples at n times: bumps' values and slopes (k, n - 1) at the middles of intervals, each a sparse row; and
    whether samples cover the windows (k,)."""

    time: Array
    value: csr_array
    slope: csr_array
    covered: np.ndarray

    def integral(self, signal: Array) -> Array:
        """∫ phi g dt of g (n,) or (n, m)."""
        return self._sum(self.value, middles(signal), self.time)

    def slope_integral(self, signal: Array) -> Array:
        """∫ phi' g dt."""
        return self._sum(self.slope, middles(signal), self.time)

    def along(self, factor: Array, position: Array) -> Array:
        """∫ phi g dx of g and x (n,)."""
        return np.asarray(self.value @ (middles(factor) * np.diff(position)))

    def slope_along(self, factor: Array, position: Array) -> Array:
        """∫ phi' g dx."""
        return np.asarray(self.slope @ (middles(factor) * np.diff(position)))

    @staticmethod
    def _sum(rows: csr_array, middle: Array, time: Array) -> Array:
        return np.asarray(rows @ (middle.T * np.diff(time)).T)


@dataclass(frozen=True)
class Bumps:
    """Centres (k,) and the whole width, s."""

    centres: Array
    width: float

    @classmethod
    def over(cls, time: Array, width: float) -> Bumps:
        """Evenly over the times (n,); none where they are shorter than one width."""
        start, stop = time[0] + width / 2, time[-1] - width / 2
        return cls(np.arange(start, stop, width / OVERLAP), width)

    def on(self, time: Array, late: float = 0.0) -> Sums:
        """For samples at times (n,), each taken `late` s after what it tells."""
        middle, half = middles(time) - late, self.width / 2
        first = np.searchsorted(middle, self.centres - half)
        last = np.searchsorted(middle, self.centres + half)
        count = last - first
        starts = np.concatenate([[0], np.cumsum(count)])
        columns = np.arange(starts[-1]) - np.repeat(starts[:-1] - first, count)
        s = (middle[columns] - np.repeat(self.centres, count)) / half
        value, slope = (1 - s**2) ** POWER, -2 * POWER * s * (1 - s**2) ** (POWER - 1) / half
        shape = (len(self.centres), len(middle))
        values, slopes = (csr_array((numbers, columns, starts), shape=shape) for numbers in (value, slope))
        return Sums(time, values, slopes, self._covered(time - late))

    def _covered(self, time: Array) -> np.ndarray:
        wide = np.flatnonzero(np.diff(time) > self.width / COVERED)
        first = np.searchsorted(time[wide + 1], self.centres - self.width / 2, side="right")
        last = np.searchsorted(time[wide], self.centres + self.width / 2)
        inside = (self.centres - self.width / 2 >= time[0]) & (self.centres + self.width / 2 <= time[-1])
        return np.asarray(inside & (last <= first))


def middles(signal: Array) -> Array:
    """Means of neighbours along the first axis."""
    return np.asarray((signal[1:] + signal[:-1]) / 2)
