"""Whether the load has changed: a chi-squared test over the last rows."""

from __future__ import annotations

from ..health import Health
from ..resets import Resets
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
        self._resets = Resets()
        self._outliers = 0.0
        self.ratio = 0.0

    def note(self, time: float, square: float) -> bool:
        """Whether the parameters should be opened now."""
        self.go_on(time)
        self._seen += 1
        self.ratio = square / (GATE * self._n)
        self._outliers += SMOOTHING * (float(square > GATE * self._n) - self._outliers)
        self._squares = (*self._squares, min(square, GATE * self._n))[-ROWS:]
        may = self._seen >= SETTLING_ROWS and self._resets.are_allowed
        if not may or sum(self._squares) < self._limit:
            return False
        self._resets, self._squares = self._resets.one_more(), ()
        return True

    def go_on(self, time: float) -> None:
        """Nothing new up to a time."""
        self._resets = self._resets.at(time)

    @property
    def health(self) -> Health:
        if self._resets.health is Health.OK and self._outliers > OUTLYING_SHARE:
            return Health.OUTLIERS
        return self._resets.health
