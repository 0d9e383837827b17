"""Poses that come again, to the last bit, under new stamps: a tracker that has frozen, or a loop that hands over the
last pose where no new one came. Taken as measurements, they say that a cart which moves has been stopped.

Where the cart moves, such a pose is none. Where it stands, it is one, unless the sensor was seen to tell its noise
there: many poses of a cart at rest of which hardly any came again. Of velocities, `repeated_velocities.py` says the
same.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cartgrasp.motion import Measurement, Motion

MIN_MOVING_SPEED = 0.05
"""m/s, or rad/s: faster than what rests is believed to be."""
REST_CALIBRATION_POSES, MAX_CHANCE_REPEAT_FRACTION = 200, 0.05
"""Poses at rest after which noise was told or not; share of these that may have come again by chance."""


class RepeatedPoses:
    """Takes samples in the order in which they come; those that are older than the newest pass unseen."""

    def __init__(self) -> None:
        self._pose, self._velocity, self._time = b"", b"", -math.inf
        self._at_rest = self._again = 0

    def without_repeats(self, measurement: Measurement, motion: Motion | None) -> Measurement:
        """Without a pose that is none, and a velocity that comes again with it; `motion` is what was believed before
        this sample."""
        if measurement.pose is None or not measurement.time > self._time:
            return measurement
        pose = np.asarray(measurement.pose, dtype=float).tobytes()
        velocity = b"" if measurement.velocity is None else np.asarray(measurement.velocity, dtype=float).tobytes()
        is_again, is_same = pose == self._pose, velocity == self._velocity
        self._pose, self._velocity, self._time = pose, velocity, measurement.time
        if not (is_again or self._at_rest < REST_CALIBRATION_POSES):
            return measurement
        is_moving = motion is not None and _moves(motion)
        if is_again and (is_moving or self._tells_noise):
            return replace(measurement, pose=None, velocity=None if is_same else measurement.velocity)
        if self._at_rest < REST_CALIBRATION_POSES and not is_moving:
            self._at_rest, self._again = self._at_rest + 1, self._again + is_again
        return measurement

    @property
    def _tells_noise(self) -> bool:
        return (
            self._at_rest >= REST_CALIBRATION_POSES
            and self._again < MAX_CHANCE_REPEAT_FRACTION * REST_CALIBRATION_POSES
        )


def _moves(motion: Motion) -> bool:
    speeds: list[float] = np.abs(motion.velocity).tolist()
    return max(speeds) > MIN_MOVING_SPEED
