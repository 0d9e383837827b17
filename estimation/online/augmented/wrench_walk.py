"""How fast the pushing wrench wanders, read off its own samples.

The wrench is modelled as a random walk that fades to zero, seen through white noise. What predicts a random walk best
is exponential smoothing, with a gain g that the two variances fix: `walk = noise g² / (1 - g)` per sample (Muth 1960).
So a bank of smoothers runs beside the filter, and the gain that has predicted best lately tells the walk; the fading
keeps the walk's power at what the samples show. A walk assumed wider, or a power assumed larger, lets noise pass for
wrench: the estimated wrench is then correlated with its own error, and inertia comes out too large (errors in
variables, physics 11).
"""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array

GAINS = np.array([0.02, 0.04, 0.08, 0.16, 0.32, 0.6, 0.9])[:, None]
AS_GOOD = 1.03
"""Of gains whose errors are this near to the best, the smallest is taken."""
SETTLING = 20
"""Samples before the bank is believed."""
MEMORY, LONG_MEMORY = 500, 2000
"""Samples over which errors and power are remembered."""
OUTLYING = 9.0
"""Squared errors count at most this many times their mean: a jump is no walk."""
LEAST_POWER = 0.1
"""Of the noise variance: a weaker wrench can't be told from none."""
FIRST_GAIN = 0.03
LATE = 10.0
"""Sample periods without a wrench after which nothing is known of its walk."""


class WrenchWalk:
    """Of a wrench with n components; `unknown` (n,) is the variance that its walk gains in a second while no samples
    tell. Arrays stay as they are, so that copies may share them."""

    def __init__(self, unknown: Array) -> None:
        n = len(unknown)
        self._unknown, self._rate, self._fade = unknown, unknown, np.zeros(n)
        self._level, self._error = np.zeros((len(GAINS), n)), np.zeros((len(GAINS), n))
        self._power = np.zeros(n)
        self._samples, self._time, self._since = 0, np.nan, np.nan

    def at(self, time: float) -> tuple[Array, Array]:
        """The variance (n,) that the walk gains in a second, and the share (n,) of the wrench that fades."""
        if time - self._time <= LATE * self._since:
            return self._rate, self._fade
        return self._unknown, np.zeros(len(self._unknown))

    def note(self, time: float, sample: Array, noise: Array) -> None:
        """Takes in a sample (n,) at a time (s), with the variances (n,) of its noise."""
        since, self._time = time - self._time, time
        self._samples += 1
        self._power = self._power + (sample**2 - self._power) / min(self._samples, LONG_MEMORY)
        if self._samples == 1:
            self._level = self._level + sample
            return
        self._smooth(sample)
        if since > 0:
            gain = self._best_gain() if self._samples > SETTLING else FIRST_GAIN
            self._since = since
            self._rate = noise * gain**2 / (1.0 - gain) / since
            self._fade = self._rate / (2 * np.maximum(self._power - noise, LEAST_POWER * noise + 1e-12))

    def _smooth(self, sample: Array) -> None:
        error = sample - self._level
        square = error**2
        if self._samples > SETTLING:
            square = np.minimum(square, OUTLYING * self._error)
        self._error = self._error + (square - self._error) / min(self._samples - 1, MEMORY)
        self._level = self._level + GAINS * error

    def _best_gain(self) -> Array:
        good = self._error <= AS_GOOD * self._error.min(axis=0)
        return np.asarray(GAINS[good.argmax(axis=0), 0])
