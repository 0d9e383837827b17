"""The filter's health: how much to trust a surprising sample, and whether innovations keep to what is believed."""

from __future__ import annotations

from enum import StrEnum

SMOOTHING = 0.04
LOUD, QUIET = 2.0, 1.4
HOLD_OFF = 0.6
REST_AFTER_FUTILE = 8.0
FUTILE_RESETS = 3
SETTLING_SAMPLES = 100
GATE = 25.0


class Health(StrEnum):
    """One word a controller can read."""

    OK = "ok"
    NO_WRENCH = "no_wrench"
    OUTLIERS = "outliers"
    LOAD_CHANGED = "load_changed"
    INCONSISTENT = "inconsistent"
    CLOCK = "clock_went_back"


class Watch:
    """Follows normalised innovations (1 in the mean when the model fits). When they stay loud, the load is first
    taken to have changed (a reset of the parameters' covariance); when resets do not help, the filter is called
    inconsistent."""

    def __init__(self) -> None:
        self.last: dict[str, tuple[float, int]] = {}
        self.level = 1.0
        self._hold_until = -float("inf")
        self._samples = 0
        self._resets = 0
        self._outliers = 0.0

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

    def wants_reset(self, time: float) -> bool:
        """Whether the parameters should be opened now."""
        if self.level < QUIET:
            self._resets = 0
        if self._samples < SETTLING_SAMPLES or self.level < LOUD or time < self._hold_until:
            return False
        self._resets += 1
        self._hold_until = time + (HOLD_OFF if self._resets < FUTILE_RESETS else REST_AFTER_FUTILE)
        return True

    def note_gap(self) -> None:
        self._samples = 0
        self.level = 1.0

    @property
    def health(self) -> Health:
        if self._resets >= FUTILE_RESETS:
            return Health.INCONSISTENT
        if self._resets:
            return Health.LOAD_CHANGED
        return Health.OUTLIERS if self._outliers > 0.1 else Health.OK
