"""Wrenches that come again, to the last bit, under new stamps: a force sensor, or its driver, that has frozen.

A sensor is known by its first rows: how seldom one repeats the last by chance, and whether its noise goes to and fro,
as white noise does in two rows of three. Zeros of an arm that gives nothing yet tell nothing of it. Of a sensor that
tells noise, a run of repeats that is too long for chance is no measurement. Of any other nothing is said, nor of a hand
that gives nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.motion import Measurement

from ..sensor_check.suspicion import Suspicion

SENSOR_CALIBRATION_ROWS, MIN_REVERSAL_FRACTION = 200, 0.5
"""Rows by which a sensor is known; share of these in which a component turns round, from which on that is noise."""
FALSE_FREEZE_PROBABILITY = 1e-6
"""Probability of a run that is too long for chance."""
USED_COMPONENTS = [0, 1, 5]
"""fx, fy and tz, which push a planar cart; the others may be anything."""


class FrozenWrenches:
    """Takes samples in the order in which they come; those that are older than the newest pass unseen."""

    def __init__(self) -> None:
        self._arms: dict[str, _Sensor] = {}

    def without_frozen(self, measurement: Measurement) -> Measurement:
        """With numbers that are none for wrenches that froze."""
        if not measurement.wrenches:
            return measurement
        frozen = []
        for arm, wrench in measurement.wrenches.items():
            sensor = self._arms.get(arm)
            if sensor is None:
                sensor = self._arms[arm] = _Sensor()
            if sensor.repeats(measurement.time, np.asarray(wrench, dtype=float)):
                frozen.append(arm)
        if not frozen:
            return measurement
        return replace(measurement, wrenches={**measurement.wrenches, **dict.fromkeys(frozen, np.full(6, np.nan))})

    @property
    def suspicions(self) -> Iterator[Suspicion]:
        for arm in [name for name, sensor in self._arms.items() if sensor.is_frozen]:
            words = f"{arm}: its wrench comes again to the last bit: the force sensor, or its driver, has frozen"
            yield Suspicion("repeated", arm, 1.0 - FALSE_FREEZE_PROBABILITY, None, words)


class _Sensor:
    """What is known of one arm's sensor, and the last that it told."""

    def __init__(self) -> None:
        self._time, self._last, self._run = -math.inf, b"", 0
        self._rows = self._again = 0
        self._used, self._change = [[0.0] * len(USED_COMPONENTS) for _ in range(2)]
        self._turned = [0] * len(USED_COMPONENTS)
        self.is_frozen = False
        """Whether the last wrench of it was none."""
        self._longest: int | None = None  # run that may be by chance; None: it tells no noise, or is not known

    def repeats(self, time: float, wrench: Array) -> bool:
        if not time > self._time:
            return False
        self._time, told = time, wrench.tobytes()
        is_again, self._last = told == self._last, told
        self._run = self._run + 1 if is_again else 0
        if self._rows < SENSOR_CALIBRATION_ROWS:
            self._learn(wrench, is_again)
        is_too_long = self._longest is not None and self._run > self._longest
        self.is_frozen = is_too_long and _pushes(_used(wrench))
        return self.is_frozen

    def _learn(self, wrench: Array, is_again: bool) -> None:
        used = _used(wrench)
        if not _pushes(used):
            return
        for i, new in enumerate(used):
            change = new - self._used[i]
            self._turned[i] += change * self._change[i] < 0.0
            self._used[i], self._change[i] = new, change
        self._rows, self._again = self._rows + 1, self._again + is_again
        if (
            self._rows == SENSOR_CALIBRATION_ROWS
            and max(self._turned) > MIN_REVERSAL_FRACTION * SENSOR_CALIBRATION_ROWS
        ):
            self._longest = math.ceil(
                math.log(FALSE_FREEZE_PROBABILITY) / math.log((self._again + 1) / (SENSOR_CALIBRATION_ROWS + 2))
            )


def _used(wrench: Array) -> list[float]:
    numbers = wrench.tolist()
    return [numbers[i] for i in USED_COMPONENTS]


def _pushes(used: list[float]) -> bool:
    """Whether something is told of what pushes."""
    fx, fy, tz = used
    return math.isfinite(fx + fy + tz) and (fx != 0.0 or fy != 0.0 or tz != 0.0)
