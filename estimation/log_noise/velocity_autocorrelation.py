"""Autocorrelated velocity noise, as estimators and low-passed encoders make.

Taken for white it looks quieter than it is, twice: from one sample to the next it hardly changes, and means of many
are no better than those of few. A smoother that believes in it finds accelerations that are noise. It is read where no
motion can be: wheels that roll don't go sideways.
"""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array

from .variogram import MIN_LAG_DIFFERENCES, Variogram, autoregression, in_means, in_third_differences

CORRELATION_TIMES = np.geomspace(0.006, 0.12, 14)
"""s: correlation times that are tried."""
SLIP_TIMES = np.array([0.2, 0.4, 0.8])
"""s: for as long as this a cart that slips keeps its sideways speed."""
MIN_MISFIT_INCREASE = 0.05
"""By how much worse what slips and white noise alone fit, in squares of the relative misfit summed over lags."""


def noise_scale(time: Array, sideways: Array) -> float:
    """How many times as loud white noise is that spoils long means of velocities as much, as white noise that makes
    the same third differences; from the axle's speeds across its wheels (n,), m/s. 1 where noise may as well be
    white."""
    grown = Variogram.of(time, sideways, np.ones(len(time), dtype=bool)) if len(time) > MIN_LAG_DIFFERENCES else None
    if grown is None:
        return 1.0
    smooth = min(grown.shares(autoregression(grown.lag, one))[1] for one in SLIP_TIMES)
    fits = [(*grown.shares(autoregression(grown.lag, one)), one) for one in CORRELATION_TIMES]
    (white, slow, _), misfit, fade = min(fits, key=lambda fit: fit[1])
    if smooth - misfit < MIN_MISFIT_INCREASE:
        return 1.0
    keep = float(np.exp(-np.median(np.diff(time)) / fade))
    return float(np.sqrt((white + slow * in_means(keep)) / (white + slow * in_third_differences(keep))))
