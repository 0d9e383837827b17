"""Whether the load may have changed: two tests over the last rows, which open hypotheses (`load_hypotheses.py`).

A chi-squared test sees whatever fits badly, at once. A load that is put on pulls many rows the same way, each by
little: for every moment of the last seconds, the evidence that the parameters changed then by a load is
`log p(rows | changed) - log p(rows | not)`, with the load normal. Without a change its exponential is a martingale of
mean 1, so it is beyond 1 / alarm with a probability of less than the alarm (Ville 1939).
"""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array

from ...health import Health
from ..kernels import belief as kernels
from ..kernels.sensor_health import MAX_OUTLIER_FRACTION
from ..resets import Resets
from ..whiteness import Whiteness
from .load_hypotheses import LoadHypotheses
from .regression_belief import ROW_GATE, Innovation
from .wrench_noise_scale import WrenchNoiseScale

CHI2_TEST_ROWS = 10
"""Rows of the chi-squared test: a second."""
FALSE_ALARM_PROBABILITY, FALSE_LOAD_PROBABILITY = 1e-3, 1e-2
"""Probabilities of a false alarm: of the chi-squared test in each row, and of the other test for each moment."""
CHANGE_WINDOW_ROWS = 60
"""Rows over which a change is looked for."""
NOISE_SETTLING_ROWS = 20
"""Rows by which the noise scale is known. In fewer a load must be as much likelier than more noise; else deviations are
reported as if there were as much noise as it seems."""
OUTLIER_ROW_WEIGHT = 0.1
MISFIT_WINDOW_ROWS, MAX_MISFIT_FRACTION = 200, 0.15
"""Rows over which is counted how many a push is said to have been in, or are outliers, and the share of them beyond
which it is the model that does not fit."""
RECOVERY_ROWS = 5
"""Rows in a row after which a model that did not fit does again."""


class LoadMonitor:
    """Sums normalised squares of rows with n components. When they are too large hypotheses are opened; when loads or
    pushes come of that too often, it is the model that does not fit."""

    def __init__(self, n: int, n_parameters: int) -> None:
        from scipy.special import gammainccinv

        self._n = n
        self._limit = 2.0 * float(gammainccinv(CHI2_TEST_ROWS * n / 2, FALSE_ALARM_PROBABILITY))
        self._squares: tuple[float, ...] = ()
        self._since, self._n_parameters = _nothing(n_parameters), n_parameters
        self._rows_seen = 0
        self._resets = Resets()
        self._outlier_fraction = 0.0
        self._misfit_fraction = 0.0  # share of the last rows
        self._fitting_again: int | None = None  # rows that fitted since a push that did not end; None: there was none
        self._is_change_reported = False  # whether a load or a push is told, though not yet for good
        self._white = Whiteness()
        self._unsettled_excess = 1.0
        self.ratio, self.health = 0.0, Health.OK

    def note(self, time: float, innovation: Innovation, root: Array, noise_scale: WrenchNoiseScale) -> bool:
        """Whether a load has to be thought of now; `root @ rootᵀ`, of (f, m), is the covariance of what a load
        changes."""
        self.follow(time, innovation)
        self._since = _followed(self._since, (innovation.information, innovation.by_noise, innovation.pull))
        self._rows_seen += 1
        self._squares = (*self._squares, min(innovation.square, ROW_GATE * self._n))[-CHI2_TEST_ROWS:]
        may = self._resets.are_allowed and self._fits
        is_suspected = may and not self._rows_fit(root, noise_scale)
        if is_suspected:
            self._begin_anew()
        return is_suspected

    def _rows_fit(self, root: Array, noise_scale: WrenchNoiseScale) -> bool:
        """Whether the last rows are as they should be. Sets how much wider deviations are told until that is known."""
        by_load = self._evidence(root) + np.log(FALSE_LOAD_PROBABILITY)
        is_settled = self._rows_seen >= NOISE_SETTLING_ROWS
        self._unsettled_excess = 1.0 if is_settled or by_load < 0.0 else noise_scale.excess
        if is_settled:
            return bool(sum(self._squares) < self._limit and by_load < 0.0)
        return bool(by_load < noise_scale.gain)

    def note_decision(self, time: float, *, is_load: bool) -> None:
        """Somebody else found another load, or a push."""
        self._resets = self._resets.one_more(time, is_load=is_load)
        self._is_change_reported, self._fitting_again = False, None
        self._begin_anew()
        self._set_health()

    def _begin_anew(self) -> None:
        self._white = self._white.interrupted()
        self._squares = ()
        self._since = _nothing(self._n_parameters)

    def settle(self, time: float, hypotheses: LoadHypotheses) -> None:
        """How far a load that was thought of is told. Whatever surprised speaks against the model, but for another
        floor. Of a push that does not end nothing more is thought until rows fit again."""
        self._is_change_reported = hypotheses.is_reported and not hypotheses.is_over
        if hypotheses.is_over:
            self._fitting_again = 0 if hypotheses.is_endless else None
        if hypotheses.is_over and not hypotheses.is_on_another_floor:
            self._resets = self._resets.one_more(time, is_load=hypotheses.is_loaded)
        self._set_health()

    def follow(self, time: float, innovation: Innovation, *, is_pushed: bool = False) -> None:
        """Health after a row; whether a push is said to be in it."""
        self._resets = self._resets.at(time)
        self.ratio = innovation.square / (ROW_GATE * self._n)
        self._misfit_fraction += (float(is_pushed or self.ratio > 1.0) - self._misfit_fraction) / MISFIT_WINDOW_ROWS
        self._outlier_fraction += OUTLIER_ROW_WEIGHT * (float(self.ratio > 1.0) - self._outlier_fraction)
        if self.ratio <= 1.0:
            self._white = self._white.and_then(time, innovation.pull, innovation.information)
        if self._fitting_again is not None:
            fitting = self._fitting_again + 1 if self.ratio <= 1.0 else 0
            self._fitting_again = fitting if fitting < RECOVERY_ROWS else None
        self._set_health()

    @property
    def excess(self) -> float:
        """How many times as large as told the variance of sums of innovations over seconds is, of which estimates are
        made: at least, but for chance; while it may be a load or noise, as much as noise may be."""
        return max(self._white.level / (1.0 + self._white.chance), self._unsettled_excess)

    @property
    def _fits(self) -> bool:
        return self._fitting_again is None and self._misfit_fraction < MAX_MISFIT_FRACTION

    def _set_health(self) -> None:
        """Sets the health: the first that holds."""
        if not self._fits or self._resets.are_too_many or self._white.is_coloured:
            self.health = Health.INCONSISTENT
        elif self._is_change_reported or self._resets.has_new_load:
            self.health = Health.LOAD_CHANGED
        else:
            self.health = Health.OUTLIERS if self._outlier_fraction > MAX_OUTLIER_FRACTION else Health.OK

    def _evidence(self, root: Array) -> float:
        """The log evidence of a load at the most likely moment."""
        return kernels.evidence(self._since, root)

    def note_time(self, time: float) -> None:
        """Nothing new up to a time."""
        if self._resets.times:
            self._resets = self._resets.at(time)
            self._set_health()


Since = tuple[Array, Array, Array]
"""Since each of the last n moments: information (n, f, f), that by noise (n, f, f), and the score (n, f)."""


def _nothing(f: int) -> Since:
    return np.zeros((0, f, f)), np.zeros((0, f, f)), np.zeros((0, f))


def _followed(since: Since, more: Since) -> Since:
    """With those of a row, which is one moment more."""
    information, by_noise, score = (
        np.concatenate([old[1 - CHANGE_WINDOW_ROWS :], np.zeros((1, *new.shape))]) + new
        for old, new in zip(since, more, strict=True)
    )
    return information, by_noise, score
