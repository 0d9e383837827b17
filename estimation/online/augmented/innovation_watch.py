"""How much to trust a surprising sample, and whether innovations keep to what is believed."""

from __future__ import annotations

from typing import Self

from cartgrasp.frames import Array
from cartgrasp.shallow import shallow

from ...health import Health
from ..kernels.correction import GATE
from ..resets import Resets
from ..whiteness import Whiteness

SMOOTHING = 0.01
"""Share of a new sample in the level: slower than a caster's turning round, which is loud for a moment too."""
LOUD = 2.7
SETTLING_SAMPLES = 100


class InnovationWatch:
    """Follows normalised innovations (1 in the mean when the model fits). When they get loud, the load is taken to
    have changed (a reset of the parameters' covariance); when that happens too often, it is the model that does not
    fit, and the filter is called inconsistent."""

    def __init__(self) -> None:
        self.last: dict[str, tuple[float, int]] = {}
        self.level = 1.0
        self._samples = 0
        self._resets = Resets()
        self._outliers = 0.0
        self._white = Whiteness()

    def copy(self) -> Self:
        other = shallow(self)
        other.last = dict(self.last)
        return other

    def noise_scale(self, sensor: str, nis: float, size: int) -> float:
        """By how much to widen the noise of a sample with this NIS: outliers pull, but can't tear."""
        self.last[sensor] = (nis, size)
        if sensor == "wrench":
            return 1.0
        self._samples += 1
        self.level += SMOOTHING * (min(nis / size, GATE) - self.level)
        is_outlier = nis > GATE * size
        self._outliers += SMOOTHING * (float(is_outlier) - self._outliers)
        return nis / (GATE * size) if is_outlier else 1.0

    def note_news(self, time: float, pull: Array, variance: Array) -> None:
        """How innovations that are no outliers pull, with the variance of that."""
        self._white = self._white.and_then(time, pull, variance)

    def wants_reset(self, time: float) -> bool:
        """Whether the parameters should be opened now."""
        self._resets = self._resets.at(time)
        may = self._samples >= SETTLING_SAMPLES and self._resets.are_allowed
        if not may or self.level < LOUD:
            return False
        self._resets = self._resets.one_more(time)
        self.level, self._white = 1.0, self._white.interrupted()
        return True

    def note_gap(self) -> None:
        self._samples = 0
        self.level, self._white = 1.0, self._white.interrupted()

    @property
    def health(self) -> Health:
        return self._resets.health_beside(self._outliers, self._white)
