"""Velocities that come again, to the last bit, under new stamps: a source that has frozen, or zeros that nobody filled
in. Taken as measurements, they say that a cart goes on as it does not.

Such a velocity is none of a sensor that was seen to tell its noise, nor where poses have gone elsewhere since than it
says. One of a coarse sensor is as good as any.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.frames import Array
from cartgrasp.motion import Measurement

from .measured_motion import usable
from .repeated_poses import MAX_CHANCE_REPEAT_FRACTION
from .sensor_block import wrapped

CALIBRATION_VELOCITIES, MAX_WAY_ERROR = 50, 0.05
"""Velocities after which noise was told or not; m or rad that a velocity may be wrong by."""


class RepeatedVelocities:
    """Takes samples in the order in which they come; those that are older than the newest pass unseen."""

    def __init__(self) -> None:
        self._velocity, self._time = b"", -math.inf
        self._seen = self._again = 0
        self._began: tuple[float, ArrayLike] | None = None  # the first pose since it is the same

    def without_repeats(self, measurement: Measurement) -> Measurement:
        """Without a velocity that is none."""
        if measurement.velocity is None or not measurement.time > self._time:
            return measurement
        velocity, self._time = np.asarray(measurement.velocity, dtype=float), measurement.time
        told = velocity.tobytes()
        is_again, self._velocity = told == self._velocity, told
        if self._seen < CALIBRATION_VELOCITIES:
            self._seen, self._again = self._seen + 1, self._again + is_again
        if not is_again:
            self._began = None if measurement.pose is None else (self._time, measurement.pose)
            return measurement
        if self._tells_noise or (
            measurement.pose is not None and self._goes_elsewhere(measurement.pose, usable(velocity))
        ):
            return replace(measurement, velocity=None)
        return measurement

    @property
    def _tells_noise(self) -> bool:
        return (
            self._seen == CALIBRATION_VELOCITIES and self._again < MAX_CHANCE_REPEAT_FRACTION * CALIBRATION_VELOCITIES
        )

    def _goes_elsewhere(self, pose: ArrayLike, velocity: Array) -> bool:
        """Whether a pose is elsewhere than the velocity says that came since the first one."""
        if self._began is None or not np.isfinite(usable(self._began[1])).all():
            self._began = self._time, pose
            return False
        since, first = self._began
        off = usable(pose) - usable(first) - (self._time - since) * velocity
        if not np.isfinite(off).all():
            return False
        return bool(math.hypot(off[0], off[1]) > MAX_WAY_ERROR or abs(wrapped(off[2])) > MAX_WAY_ERROR)
