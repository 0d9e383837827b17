"""Variograms: half the squares of differences over lags, from which kinds of noise can be told.

White noise gives the same at all lags, an autoregression grows with `1 - exp(-t / time)`, and what changes smoothly
with `t²`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import numpy as np
from scipy.optimize import nnls

from cartgrasp.frames import Array

LONGEST, FEWEST_LAGS, MOST_LAGS = 0.25, 8, 18
"""s: of lags; how many of them, at least and at most."""
LONGEST_THIRD = 0.12
"""s: of lags of third differences, over which a cart may do anything."""
FEWEST = 200
"""Differences."""
MEDIAN_OF_SQUARE = 0.4549
"""Of a standard normal number."""


@final
@dataclass(frozen=True)
class Variogram:
    """At lags (l,), s."""

    lag: Array
    value: Array

    @classmethod
    def of(cls, time: Array, series: Array, which: np.ndarray) -> Variogram | None:
        """Of a series (n,) from the rows `which` (n,) on, by medians; None where there are too few."""
        step = float(np.median(np.diff(time)))
        lags = np.unique(np.round(np.geomspace(1, max(FEWEST_LAGS, LONGEST / step), MOST_LAGS)).astype(int))
        found = []
        for lag in lags:
            near = which[:-lag] & ((time[lag:] - time[:-lag]) < (lag + 0.5) * step)
            if near.sum() < FEWEST:
                return None
            found.append(float(np.median((series[lag:] - series[:-lag])[near] ** 2)) / MEDIAN_OF_SQUARE / 2)
        return cls(lags * step, np.array(found)) if min(found) > 0 else None

    @classmethod
    def of_third_differences(cls, time: Array, series: Array) -> Variogram | None:
        """Of series (n, k), by medians of third differences over lags, in units in which white noise gives its
        variance; None where there are too few."""
        step = float(np.median(np.diff(time)))
        lags = np.unique(np.round(np.geomspace(1, max(6.0, LONGEST_THIRD / step), 16)).astype(int))
        found = []
        for lag in lags:
            near = (time[3 * lag :] - time[: -3 * lag]) < (3 * lag + 0.5) * step
            if near.sum() < FEWEST:
                return None
            later, earlier = series[2 * lag :], series[: -2 * lag]
            third = later[lag:] - 3 * later[:-lag] + 3 * earlier[lag:] - earlier[:-lag]
            found.append(float(np.median(third[near] ** 2, axis=0).mean()) / MEDIAN_OF_SQUARE / 20)
        return cls(lags * step, np.array(found)) if min(found) > 0 else None

    def beside_motion(self, time: float | None) -> tuple[Array, float]:
        """Of third differences: variances of white noise and of an autoregression of a correlation time (s), if any,
        beside jumps of velocity, of acceleration, and smoother motion; and the squares of the relative misfit."""
        noise = [np.ones(len(self.lag))]
        if time is not None:
            noise.append(in_third_differences(np.exp(-self.lag / time)))
        motion = [(self.lag / self.lag[-1]) ** power for power in (3, 4, 5, 6)]
        shares, misfit = nnls(np.column_stack(noise + motion) / self.value[:, None], np.ones(len(self.lag)))
        return shares[: len(noise)], float(misfit)

    def shares(self, other: Array) -> tuple[Array, float]:
        """Variances of white noise, of another kind (l,) and of smooth change, none negative, and the squares of the
        relative misfit."""
        columns = np.column_stack([np.ones(len(self.lag)), other, (self.lag / self.lag[-1]) ** 2])
        shares, misfit = nnls(columns / self.value[:, None], np.ones(len(self.lag)))
        return shares, float(misfit)


def autoregression(lag: Array, time: float) -> Array:
    """Of unit variance."""
    return np.asarray(1 - np.exp(-lag / time))


def in_means(fade: float) -> float:
    """Variance of white noise that spoils long means as much as an autoregression of unit variance that fades so from
    one sample to the next."""
    return (1 + fade) / (1 - fade)


def in_third_differences(fade: Any) -> Any:
    """Variance of white noise that makes the same third differences as it."""
    return 1 - 1.5 * fade + 0.6 * fade**2 - 0.1 * fade**3
