"""What an estimator says of itself: one word, and how each sensor does."""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array

from .online.kernels.sensor_health import OUTLYING, POSE_MISSED, WRENCH_MISSED


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
    counts less (of `wrench`, that of the regression's last row), and the `outlying` share of the last samples; whether
    nothing has come for too long."""

    time: float
    ratio: float
    outlying: float
    is_missed: bool


def empty_health_table() -> Array:
    """The table of `kernels/sensor_health.py`, before any sample."""
    return np.tile([-math.inf, math.nan, 0.0, 0.0], (len(SENSORS), 1))


def by_sensor(table: Array) -> Mapping[str, SensorHealth]:
    rows = zip(SENSORS, table.tolist(), strict=True)
    return {sensor: SensorHealth(time, ratio, outlying, missed > 0) for sensor, (time, ratio, outlying, missed) in rows}


def overall_health(of_sensors: int, learner: Health) -> Health:
    """The first that holds, of what is said of the sensors and by what learns from them."""
    if of_sensors & POSE_MISSED or learner is Health.STALE:
        return Health.STALE
    if of_sensors & WRENCH_MISSED:
        return Health.NO_WRENCH
    return Health.OUTLIERS if of_sensors & OUTLYING and learner is Health.OK else learner
