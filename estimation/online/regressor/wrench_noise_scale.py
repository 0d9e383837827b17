"""Noise scale of wrenches: the variance of their noise, over a row, beside that of white samples as declared.

Autocorrelated noise adds up: of samples `dt` apart, with a correlation time t, means over a row have `coth(dt / 2 t)`
times the variance of means of white ones, and next to nothing of it shows from sample to sample. So the innovations of
rows tell it: `log p(rows | factor)`, in which older ones fade. What a model lacks goes on pulling the same way, and
noise of sensors does not for long; so it is told by differences of innovations that are some rows apart, in which the
former is gone (von Neumann 1941).
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import NamedTuple, Self

import numpy as np

from cartgrasp.frames import Array

from ...sensor_check.suspicion import Suspicion
from .regression_belief import Innovation, log_likelihood

NOISE_VARIANCE_FACTORS = 2.0 ** np.arange(7)
"""Times the declared variance: white noise, to a correlation time of 32 samples."""
DOUBLING_PENALTY_NATS = 10.0
"""Nats for each doubling, beforehand."""
DOUBLING_PENALTIES = DOUBLING_PENALTY_NATS * np.arange(len(NOISE_VARIANCE_FACTORS))
NOISE_FORGETTING_FACTOR = 0.998
"""Share that is kept with each row of what older ones told; ten come a second."""
DIFFERENCE_LAG_ROWS = 3
"""Rows from one innovation to that from which it differs: 0.3 s."""
DIFFERENCE_GATE = 6.0
"""Normalised squares, by component, beyond which a difference counts as no noisier: what jumps is no noise."""
MIN_REPORTED_NOISE_RATIO = 1.5
"""Times the declared deviation."""


class Row(NamedTuple):
    """A row's innovation (n,), its covariance (n, n) if parameters were known and wrenches exact, and that of white
    samples."""

    value: Array
    other: Array
    of_wrenches: Array


@dataclass(frozen=True, eq=False)
class WrenchNoiseScale:
    """The log-likelihood of each level; the likeliest, on which the next row counts; and the last rows."""

    log_likelihoods: Array = field(default_factory=lambda: np.zeros(len(NOISE_VARIANCE_FACTORS)))
    variance_factor: float = 1.0
    last: tuple[Row, ...] = ()

    def after(self, innovation: Innovation) -> Self:
        """After a row that counted on `variance_factor`. One without noise, or beyond numbers, tells nothing."""
        of_wrenches = innovation.of_wrenches
        row = Row(innovation.value, innovation.of_known - self.variance_factor * of_wrenches, of_wrenches)
        last = (*self.last, row)[-DIFFERENCE_LAG_ROWS:]
        if len(self.last) < DIFFERENCE_LAG_ROWS:
            return replace(self, last=last)
        before = self.last[0]
        spread = (
            row.other + before.other + NOISE_VARIANCE_FACTORS[:, None, None] * (row.of_wrenches + before.of_wrenches)
        )
        told = np.full(len(NOISE_VARIANCE_FACTORS), np.nan)
        with suppress(np.linalg.LinAlgError):
            told = NOISE_FORGETTING_FACTOR * self.log_likelihoods + log_likelihood(
                row.value - before.value, spread, DIFFERENCE_GATE
            )
        if not np.isfinite(told).all():
            return replace(self, last=last)
        return type(self)(told, float(NOISE_VARIANCE_FACTORS[np.argmax(told - DOUBLING_PENALTIES)]), last)

    @property
    def gain(self) -> float:
        """How much likelier (a logarithm) the last rows are with the level that suits them best."""
        return float(self.log_likelihoods.max() - self.log_likelihoods[round(math.log2(self.variance_factor))])

    @property
    def excess(self) -> float:
        """How many times the variance that level has, 1 at least."""
        return max(float(NOISE_VARIANCE_FACTORS[np.argmax(self.log_likelihoods)]) / self.variance_factor, 1.0)

    @property
    def suspicions(self) -> tuple[Suspicion, ...]:
        times = math.sqrt(self.variance_factor)
        if times < MIN_REPORTED_NOISE_RATIO:
            return ()
        words = f"over 0.1 s wrenches are {times:.1f} times as noisy as declared white samples, and taken as such"
        return (Suspicion("noise", "wrench", 1.0, times, words),)
