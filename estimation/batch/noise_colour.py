"""Wrench noise that remembers: white noise, and an autoregression beside it that fades with a correlation time.

Taken for white, it makes long means look surer than they are, and slow accidents look like effects. What a model
leaves out changes slowly too, but smoothly: over a lag t, squares of differences of it grow with t², those of an
autoregression with `1 - exp(-t / time)`, those of white noise not at all. A fit of the three to lags up to `LONGEST`
tells them apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.optimize import nnls

from cartgrasp.frames import Array

from ..variogram import FEWEST, LONGEST, MEDIAN_OF_SQUARE, in_means
from .block_tridiagonal import BlockTridiagonal

TIMES = np.geomspace(0.015, 0.2, 24)
"""s: correlation times that are tried."""
LEAST_WHITE = 0.02
"""Of all: the share of the variance that is white at least."""
WHITE = 0.0145
"""s: noise that forgets within less may as well be white."""
LOUDER = 1.25
"""Times the variance that was believed: white noise that is no louder is as believed."""


@final
@dataclass(frozen=True)
class NoiseColour:
    """Variances as multiples of those that were believed, and the correlation time (s) of the slow part."""

    white: float
    slow: float
    time: float

    @property
    def remembers(self) -> bool:
        return self.slow > 0

    def long_mean(self, step: float) -> float:
        """How many times the variance of long means is what white noise of the whole variance would give, for
        samples `step` (s) apart."""
        fade = float(np.exp(-step / self.time))
        return (self.white + self.slow * in_means(fade)) / (self.white + self.slow)


def colour_of(time: Array, standard: Array, size: int = 1, known: Array | None = None) -> NoiseColour | None:
    """Of residuals (m, f), means of `size` samples, in units of their believed deviations; `known` (m, k) is drawn of
    what is in them beside noise, errors of the smoothed motion. None where there are too few, and where they may as
    well be white, and as loud as believed."""
    step = float(np.median(np.diff(time)))
    lags = np.unique(np.round(np.geomspace(1, max(2.0, LONGEST / step), 14)).astype(int))
    found = []
    for lag in lags:
        near = (time[lag:] - time[:-lag]) < (lag + 0.5) * step
        if near.sum() < FEWEST:
            return None
        squares = [(each[lag:] - each[:-lag])[near] ** 2 for each in (standard, known) if each is not None]
        found.append([float(np.median(each)) / MEDIAN_OF_SQUARE for each in squares])
    whole, beside = (np.array(found) @ np.eye(len(found[0]), 2)).T
    fits = [
        (_fitted((whole, beside), lags, _correlation(lags, np.exp(-step / size / one), size)), one) for one in TIMES
    ]
    (shares, _), best = min(fits, key=lambda fit: fit[0][1])
    white, slow, _ = shares
    whole = white + slow
    if whole <= 0:
        return None
    colour = NoiseColour(float(max(white, LEAST_WHITE * whole)), float(slow), float(best))
    if colour.long_mean(step) > NoiseColour(0.0, 1.0, WHITE).long_mean(step):
        return colour
    return NoiseColour(float(whole), 0.0, float(best)) if whole > LOUDER else None


def _correlation(lags: np.ndarray, fade: float, size: int) -> Array:
    """Of means of `size` samples that fade from one to the next, at 0 and at lags, as a share of one's variance."""
    apart = np.subtract.outer(np.arange(size), np.arange(size))
    between = np.append(0, lags)[:, None, None] * size + apart
    return np.asarray((fade ** np.abs(between)).mean(axis=(1, 2)))


def _fitted(grown: tuple[Array, Array], lags: np.ndarray, correlation: Array) -> tuple[Array, float]:
    """Shares of white noise, slow noise and misfit in squares of differences, beside what is known of them."""
    whole, known = grown
    slow = 2 * (correlation[0] - correlation[1:])
    columns = np.column_stack([np.full(len(lags), 2.0), slow, (lags / lags[-1]) ** 2])
    shares, misfit = nnls(columns / whole[:, None], np.maximum(1.0 - known / whole, 0.0))
    return shares, float(misfit)


def with_noise_states(
    motion: BlockTridiagonal, linked: np.ndarray, steps: Array, covariance: Array, colour: NoiseColour
) -> BlockTridiagonal:
    """The information about a motion (n, d, d) with the slow noise (f) behind each state; `covariance` (f, f) is what
    was believed of one sample."""
    n, d, _ = motion.diagonal.shape
    f = len(covariance)
    weight = np.linalg.inv(colour.slow * covariance)
    fade = np.exp(-steps / colour.time)
    first, second = np.zeros((n - 1, f, d + f)), np.zeros((n - 1, f, d + f))
    second[:, :, d:] = np.eye(f)
    first[:, :, d:] = -fade[:, None, None] * np.eye(f)
    strength = np.where(linked, 1 / np.maximum(1 - fade**2, 1e-12), 0.0)
    chain = BlockTridiagonal.of_pairs(first, second, strength[:, None, None] * weight)
    begins = np.append(True, ~linked)
    chain.diagonal[begins, d:, d:] += weight
    chain.diagonal[:, :d, :d] += motion.diagonal
    chain.below[:, :d, :d] += motion.below
    return chain
