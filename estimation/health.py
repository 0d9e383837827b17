"""What an estimator says of itself: one word, and how each sensor does."""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import StrEnum
from typing import NamedTuple

TIME_OUT = 0.5
"""s without a usable sample after which a sensor that spoke before is missed."""
OUTLYING_SHARE, SMOOTHING = 0.1, 0.05
"""Of the last samples: from how many beyond their gate on outliers are called so."""


class Health(StrEnum):
    """One word a controller can read; the first that holds."""

    CLOCK = "clock_went_back"
    STALE = "stale"
    NO_WRENCH = "no_wrench"
    INCONSISTENT = "inconsistent"
    LOAD_CHANGED = "load_changed"
    OUTLIERS = "outliers"
    OK = "ok"


SENSORS = ("pose", "velocity", "wrench")


class SensorHealth(NamedTuple):
    """The last usable sample's `time`, its `ratio`, the normalised innovation squared over the gate beyond which it
    counts less, and the `outlying` share of the last samples; whether nothing has come for too long."""

    time: float = -math.inf
    ratio: float = math.nan
    outlying: float = 0.0
    is_missed: bool = False

    def seen(self, time: float, ratio: float) -> SensorHealth:
        """After a sample; a ratio that is not finite is of one that could not be used."""
        if not math.isfinite(ratio):
            return self.later(time)
        outlying = self.outlying + SMOOTHING * (float(ratio > 1.0) - self.outlying)
        return SensorHealth(time, ratio, outlying)

    def later(self, time: float) -> SensorHealth:
        """With nothing new."""
        is_missed = self.time > -math.inf and time - self.time > TIME_OUT
        return self if is_missed == self.is_missed else SensorHealth(self.time, self.ratio, self.outlying, is_missed)

    @property
    def has_outliers(self) -> bool:
        return self.outlying > OUTLYING_SHARE


def said(sensors: Mapping[str, SensorHealth], learner: Health) -> Health:
    """The first that holds, of sensors and of what learns from them."""
    pose, velocity, wrench = sensors["pose"], sensors["velocity"], sensors["wrench"]
    if pose.is_missed:
        return Health.STALE
    if learner == Health.NO_WRENCH or wrench.is_missed:
        return Health.NO_WRENCH
    if learner != Health.OK:
        return learner
    return Health.OUTLIERS if pose.has_outliers or velocity.has_outliers else Health.OK
