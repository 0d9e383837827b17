"""Autocorrelated velocity noise, as estimators and low-passed encoders make.

Taken for white it looks quieter than it is, twice: from one sample to the next it hardly changes, and means of many
are no better than those of few. A smoother that believes in it finds accelerations that are noise. It is read where no
motion can be: wheels that roll don't go sideways.

It is told by variograms, half the squares of differences over lags: white noise gives the same at all lags, an
autoregression grows with `1 - exp(-t / time)`, and what changes smoothly with `t²`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from cartgrasp.frames import Array

CORRELATION_TIMES = np.geomspace(0.006, 0.12, 14)
"""s: correlation times that are tried."""
SLIP_TIMES = np.array([0.2, 0.4, 0.8])
"""s: for as long as this a cart that slips keeps its sideways speed."""
MIN_MISFIT_INCREASE = 0.05
"""By how much worse what slips and white noise alone fit, in squares of the relative misfit summed over lags."""
MAX_VARIOGRAM_LAG, MIN_VARIOGRAM_LAGS, MAX_VARIOGRAM_LAGS = 0.25, 8, 18
"""The longest lag, s, and how many lags there are, at least and at most."""
MIN_LAG_DIFFERENCES = 200
"""Differences."""
MEDIAN_OF_NORMAL_SQUARE = 0.4549
"""The median of the square of a standard normal number."""


@dataclass(frozen=True)
class Variogram:
    """The values of a variogram at lags (l,), s."""

    lag: Array
    value: Array

    @classmethod
    def of(cls, time: Array, series: Array) -> Variogram | None:
        """The variogram of a series (n,) by medians. None where there are too few differences."""
        if len(time) <= MIN_LAG_DIFFERENCES:
            return None
        step = float(np.median(np.diff(time)))
        lags = np.unique(
            np.round(np.geomspace(1, max(MIN_VARIOGRAM_LAGS, MAX_VARIOGRAM_LAG / step), MAX_VARIOGRAM_LAGS)).astype(int)
        )
        found = []
        for lag in lags:
            near = (time[lag:] - time[:-lag]) < (lag + 0.5) * step
            if near.sum() < MIN_LAG_DIFFERENCES:
                return None
            found.append(float(np.median((series[lag:] - series[:-lag])[near] ** 2)) / MEDIAN_OF_NORMAL_SQUARE / 2)
        return cls(lags * step, np.array(found)) if min(found) > 0 else None

    def shares(self, time: float) -> tuple[Array, float]:
        """Variances of white noise, of an autoregression that fades in a `time` (s), and of smooth change, none
        negative, and the squares of the relative misfit."""
        columns = [np.ones(len(self.lag)), 1 - np.exp(-self.lag / time), (self.lag / self.lag[-1]) ** 2]
        shares, misfit = nnls(np.column_stack(columns) / self.value[:, None], np.ones(len(self.lag)))
        return shares, float(misfit)


def noise_scale(time: Array, sideways: Array) -> float:
    """How many times as loud white noise is that spoils long means of velocities as much, as white noise that makes
    the same third differences; from the axle's speeds across its wheels (n,), m/s. 1 where noise may as well be
    white."""
    grown = Variogram.of(time, sideways)
    if grown is None:
        return 1.0
    smooth = min(grown.shares(one)[1] for one in SLIP_TIMES)
    fits = [(*grown.shares(one), one) for one in CORRELATION_TIMES]
    (white, slow, _), misfit, fade = min(fits, key=lambda fit: fit[1])
    if smooth - misfit < MIN_MISFIT_INCREASE:
        return 1.0
    keep = float(np.exp(-np.median(np.diff(time)) / fade))
    in_means = (1 + keep) / (1 - keep)
    in_third_differences = 1 - 1.5 * keep + 0.6 * keep**2 - 0.1 * keep**3
    return float(np.sqrt((white + slow * in_means) / (white + slow * in_third_differences)))
