"""Whether the load has changed: a chi-squared test over the last rows."""

from __future__ import annotations

import numpy as np

from ..health import HOLD_OFF, MEMORY, MOST_RESETS, Health
from .regression_belief import GATE

ROWS = 7
"""Of a block of the test: a second of rows."""
FALSE_ALARM = 1e-7
SETTLING_ROWS = 14
OUTLYING_SHARE, SMOOTHING = 0.1, 0.1


class LoadWatch:
    """Sums normalised squares of rows with n components. When they are too large the load is taken to have changed;
    when that happens too often, it is the model that does not fit."""

    def __init__(self, n: int) -> None:
        from scipy.special import gammainccinv

        self._n = n
        self._limit = 2.0 * float(gammainccinv(ROWS * n / 2, FALSE_ALARM))
        self._squares: tuple[float, ...] = ()
        self._seen = 0
        self._time = -np.inf
        self._resets: tuple[float, ...] = ()
        self._outliers = 0.0
        self.ratio = 0.0

    def note(self, time: float, square: float) -> bool:
        """Whether the parameters should be opened now."""
        self.go_on(time)
        self._seen += 1
        self.ratio = square / (GATE * self._n)
        self._outliers += SMOOTHING * (float(square > GATE * self._n) - self._outliers)
        self._squares = (*self._squares, min(square, GATE * self._n))[-ROWS:]
        may = self._seen >= SETTLING_ROWS and not self._just_reset and len(self._resets) < MOST_RESETS
        if not may or sum(self._squares) < self._limit:
            return False
        self._resets, self._squares = (*self._resets, time), ()
        return True

    def go_on(self, time: float) -> None:
        """Nothing new up to a time."""
        self._time = time
        if self._resets:
            self._resets = tuple(t for t in self._resets if time - t < MEMORY)

    @property
    def _just_reset(self) -> bool:
        return bool(self._resets) and self._time - self._resets[-1] < HOLD_OFF

    @property
    def health(self) -> Health:
        if len(self._resets) >= MOST_RESETS:
            return Health.INCONSISTENT
        if self._just_reset:
            return Health.LOAD_CHANGED
        return Health.OUTLIERS if self._outliers > OUTLYING_SHARE else Health.OK
