"""Probabilities of rival explanations of one motion y (n rows): each is a signal z times a gain, noise unknown in size.

With the noise integrated out under Jeffreys' prior, the likelihood of a gain is |y - gain z|^-rows; about its best it
is that of a normal in the log of the gain, whose prior is one, too. `rows` are those that count as independent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cartgrasp.frames import Array

WRONG_HEADING_ODDS = 0.01
"""Odds of each way in which headings may be wrong: one log in a hundred."""
UNEXPLAINED_FRACTION = 0.1
"""Share of a motion's size that no cart model explains: wheels slip, loads lean, frames bend."""


def probabilities(log_evidence: Array, prior: Array) -> Array:
    """Posterior (k,) of rivals with prior odds (k,)."""
    log = log_evidence + np.log(prior)
    odds = np.exp(log - log.max())
    return np.asarray(odds / odds.sum())


def evidence(left: Array, whole: float, rows: float, floor: float = UNEXPLAINED_FRACTION**2) -> Array:
    """Log evidence (k,) of rivals that leave sums of squares (k,) of the whole, of which all leave a share."""
    return np.asarray(-0.5 * rows * np.log(left / whole + floor))


def reading_probabilities(left: Sequence[tuple[Array, float]], odds: Array) -> Array:
    """Posterior (k,) of readings with prior odds (k,), from the rows (n,) that each leaves, and the sum of squares of
    those that it had to explain. The reading that leaves least tells how many rows are independent."""
    shares = np.array([float(rows @ rows) / whole for rows, whole in left])
    return probabilities(evidence(shares, 1.0, independent_rows(left[int(np.argmin(shares))][0])), odds)


def gain_evidence(
    products: tuple[Array, Array, float], rows: float, mean: Array, spread: float, floor: float
) -> tuple[Array, Array]:
    """Log evidence and best log gain (k,) of positive gains of signals with products zz, zy (k,) and yy, whose log is
    about a mean (k,) by a spread. A signal that opposes the motion is as good as none, of any gain."""
    zz, zy, yy = products
    helps = (zy > 0) & (zz > 0)
    gain = np.where(helps, zy, 1.0) / np.where(helps, zz, 1.0)
    left = yy - np.where(helps, gain * zy, 0.0)
    std = np.sqrt((left + floor * yy) / rows / np.where(helps, gain * zy, 1.0))
    far, wide = np.log(gain) - mean, np.hypot(std, spread)
    fits = -0.5 * (far / wide) ** 2 + np.log(std / wide)
    return evidence(left, yy, rows, floor) + np.where(helps, fits, 0.0), np.where(helps, np.log(gain), mean)


def independent_rows(residual: Array) -> float:
    """How many of the rows (n,), in order, count as independent: their number over the sum of autocorrelations up to
    the first that is not positive (after Geyer, 1992)."""
    n, size = len(residual), float(residual @ residual)
    if n < 3 or size <= 0:
        return float(max(n, 1))
    transform = np.fft.rfft(residual, 2 * n)
    correlation = np.fft.irfft(np.abs(transform) ** 2)[1 : n // 2] / size
    ends = np.flatnonzero(correlation <= 0)
    positive = correlation[: ends[0]] if len(ends) else correlation
    return float(n / (1 + 2 * positive.sum()))


def gross_error_probability(value: float, std: float, sound: float, wrong: float, odds: float) -> float:
    """Probability that a value measured with `std` is spread by `wrong` rather than by `sound`."""
    wide, narrow = math.hypot(std, wrong), math.hypot(std, sound)
    log_odds = 0.5 * ((value / narrow) ** 2 - (value / wide) ** 2) - math.log(wide / narrow) + math.log(odds)
    return 1 / (1 + math.exp(-min(max(log_odds, -700.0), 700.0)))
