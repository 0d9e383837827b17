"""Probabilities of rival explanations: marginal likelihoods of one gain under each, weighed with prior odds.

Motion y (n rows) is explained by a signal z that a sensor gives, times a gain of known sign and roughly known size, and
noise of unknown size:

    evidence = ∫ N(log gain; mean, spread²) |y - gain z|^-rows d(log gain)

(the noise integrated out under Jeffreys' prior) at its peak by Laplace's method. `rows` are those that count as
independent.
"""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.frames import Array

GRID = np.linspace(-8.0, 8.0, 129)
"""Of prior deviations of a log gain, where a peak is looked for beside the one of least squares."""
POLISHING = 4
"""Newton steps: from a grid of an eighth of a deviation they reach rounding."""


def probabilities(log_evidence: Array, prior: Array) -> Array:
    """Posterior (k,) of rivals of given prior probability or odds (k,)."""
    log = log_evidence + np.log(prior)
    odds = np.exp(log - log.max())
    return np.asarray(odds / odds.sum())


def from_odds(log_odds: float) -> float:
    """Probability."""
    return 1 / (1 + math.exp(-min(max(log_odds, -700.0), 700.0)))


def log_normal_density(value: Array | float, spread: Array | float) -> Array:
    """Of a normal of mean 0."""
    return np.asarray(-0.5 * (value / np.asarray(spread)) ** 2 - np.log(spread) - 0.5 * math.log(2 * math.pi))


def gain_evidence(
    products: tuple[Array, Array, float], rows: float, mean: Array, spread: Array | float, floor: float
) -> tuple[Array, Array, Array]:
    """Log evidence, log gain and its standard deviation, each (k,): of signals with products zz, zy (k,) and yy, prior
    means and spreads of the log gain (k,); `floor` is the share of yy that no model explains."""
    zz, zy, yy = products
    mean, spread = np.broadcast_to(mean, zz.shape), np.broadcast_to(spread, zz.shape)

    def height(log_gain: Array) -> Array:
        gain = np.exp(log_gain)
        left = yy - 2 * gain * zy + gain**2 * zz + floor * yy
        return np.asarray(-0.5 * rows * np.log(left) + log_normal_density(log_gain - mean, spread))

    best_fit = np.log(np.maximum(zy, 1e-300) / np.maximum(zz, 1e-300))
    tried = np.column_stack([mean[:, None] + GRID * spread[:, None], best_fit])
    heights = height(tried.T).T
    peak = tried[np.arange(len(zz)), heights.argmax(axis=1)]
    for _ in range(POLISHING):
        slope, bend = _slopes(peak, (zz, zy, yy), rows, (mean, spread), floor)
        step = np.where(bend < 0, -slope / np.where(bend < 0, bend, 1.0), 0.0)
        better = height(peak + step) >= height(peak)
        peak = np.where(better, peak + step, peak)
    bend = np.minimum(_slopes(peak, (zz, zy, yy), rows, (mean, spread), floor)[1], -1e-12)
    return height(peak) + 0.5 * np.log(2 * math.pi / -bend), peak, 1 / np.sqrt(-bend)


def _slopes(
    log_gain: Array, products: tuple[Array, Array, float], rows: float, prior: tuple[Array, Array], floor: float
) -> tuple[Array, Array]:
    """First and second derivative of the log of the integrand."""
    (zz, zy, yy), (mean, spread) = products, prior
    gain = np.exp(log_gain)
    left = yy - 2 * gain * zy + gain**2 * zz + floor * yy
    first, second = -2 * gain * zy + 2 * gain**2 * zz, -2 * gain * zy + 4 * gain**2 * zz
    share = first / left
    slope = -0.5 * rows * share - (log_gain - mean) / spread**2
    return slope, -0.5 * rows * (second / left - share**2) - 1 / spread**2


def independent_rows(residual: Array) -> float:
    """How many of the rows (n,), in order, count as independent: their number over the sum of autocorrelations up to
    the first that is not positive (after Geyer, 1992)."""
    n = len(residual)
    size = float(residual @ residual)
    if n < 3 or size <= 0:
        return float(max(n, 1))
    transform = np.fft.rfft(residual, 2 * n)
    correlation = np.fft.irfft(np.abs(transform) ** 2)[1 : n // 2] / size
    ends = np.flatnonzero(correlation <= 0)
    positive = correlation[: ends[0]] if len(ends) else correlation
    return float(n / (1 + 2 * positive.sum()))
