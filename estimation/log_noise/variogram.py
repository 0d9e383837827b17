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

MAX_VARIOGRAM_LAG, MIN_VARIOGRAM_LAGS, MAX_VARIOGRAM_LAGS = 0.25, 8, 18
"""The longest lag, s, and how many lags there are, at least and at most."""
MIN_LAG_DIFFERENCES = 200
"""Differences."""
MEDIAN_OF_NORMAL_SQUARE = 0.4549
"""The median of the square of a standard normal number."""


@final
@dataclass(frozen=True)
class Variogram:
    """The values of a variogram at lags (l,), s."""

    lag: Array
    value: Array

    @classmethod
    def of(cls, time: Array, series: Array, which: np.ndarray) -> Variogram | None:
        """The variogram of a series (n,) by medians, from differences that begin at the rows `which` (n,). None where
        there are too few."""
        step = float(np.median(np.diff(time)))
        lags = np.unique(
            np.round(np.geomspace(1, max(MIN_VARIOGRAM_LAGS, MAX_VARIOGRAM_LAG / step), MAX_VARIOGRAM_LAGS)).astype(int)
        )
        found = []
        for lag in lags:
            near = which[:-lag] & ((time[lag:] - time[:-lag]) < (lag + 0.5) * step)
            if near.sum() < MIN_LAG_DIFFERENCES:
                return None
            found.append(float(np.median((series[lag:] - series[:-lag])[near] ** 2)) / MEDIAN_OF_NORMAL_SQUARE / 2)
        return cls(lags * step, np.array(found)) if min(found) > 0 else None

    def shares(self, other: Array) -> tuple[Array, float]:
        """Variances of white noise, of another kind (l,) and of smooth change, none negative, and the squares of the
        relative misfit."""
        columns = np.column_stack([np.ones(len(self.lag)), other, (self.lag / self.lag[-1]) ** 2])
        shares, misfit = nnls(columns / self.value[:, None], np.ones(len(self.lag)))
        return shares, float(misfit)


def autoregression(lag: Array, time: float) -> Array:
    """The variogram of an autoregression of unit variance, at lags (l,), s."""
    return np.asarray(1 - np.exp(-lag / time))


def in_means(fade: float) -> float:
    """Variance of white noise that spoils long means as much as an autoregression of unit variance that fades so from
    one sample to the next."""
    return (1 + fade) / (1 - fade)


def in_third_differences(fade: Any) -> Any:
    """Variance of white noise that makes the same third differences as it."""
    return 1 - 1.5 * fade + 0.6 * fade**2 - 0.1 * fade**3
