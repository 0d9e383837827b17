"""Poses and velocities that come again, to the last bit, under new stamps: a tracker that has frozen, or a loop that
hands over the last pose where no new one came, or a velocity of zeros that nobody filled in. Taken as measurements,
they say that a cart which moves has been stopped.

Where the cart moves, such a pose is none. Where it stands, it is one, unless the sensor was seen to tell its noise
there: many poses of a cart at rest of which hardly any came again. Such a velocity is none of a sensor that was seen to
tell its noise, nor where poses have gone elsewhere since than it says.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.frames import Array
from cartgrasp.motion import Measurement, Motion

from .measured_motion import usable
from .sensor_block import wrapped

MIN_MOVING_SPEED = 0.05
"""m/s, or rad/s: faster than what rests is believed to be."""
REST_CALIBRATION_POSES, MAX_CHANCE_REPEAT_FRACTION = 200, 0.05
"""Poses at rest after which noise was told or not; share of these that may have come again by chance."""
CALIBRATION_VELOCITIES, MAX_WAY_ERROR = 50, 0.05
"""Velocities after which noise was told or not; m or rad that a velocity may be wrong by."""


class RepeatedPoses:
    """Takes samples in the order in which they come."""

    def __init__(self) -> None:
        self._pose, self._velocity, self._time = b"", b"", -math.inf
        self._at_rest = self._again = 0
        self._velocities = RepeatedVelocities()

    def without_repeats(self, measurement: Measurement, motion: Motion | None) -> Measurement:
        """Without a pose that is none, and a velocity that comes again with it; `motion` is what was believed before
        this sample."""
        return self._velocities.without_repeats(self._without_poses(measurement, motion))

    def _without_poses(self, measurement: Measurement, motion: Motion | None) -> Measurement:
        if measurement.pose is None or not measurement.time > self._time:
            return measurement
        pose, velocity = (
            b"" if one is None else np.asarray(one, dtype=float).tobytes()
            for one in (measurement.pose, measurement.velocity)
        )
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


class RepeatedVelocities:
    """Takes samples in the order in which they come."""

    def __init__(self) -> None:
        self._velocity, self._time = b"", -math.inf
        self._seen = self._again = 0
        self._began: tuple[float, Array] | None = None  # the first pose since it is the same

    def without_repeats(self, measurement: Measurement) -> Measurement:
        """Without a velocity that is none."""
        if measurement.velocity is None or not measurement.time > self._time:
            return measurement
        velocity = usable(measurement.velocity)
        told, self._time = velocity.tobytes(), measurement.time
        is_again, self._velocity = told == self._velocity, told
        if self._seen < CALIBRATION_VELOCITIES:
            self._seen, self._again = self._seen + 1, self._again + is_again
        if not is_again:
            self._began = None
        goes_elsewhere = measurement.pose is not None and self._goes_elsewhere(measurement.pose, velocity)
        is_none = is_again and (self._tells_noise or goes_elsewhere)
        return replace(measurement, velocity=None) if is_none else measurement

    @property
    def _tells_noise(self) -> bool:
        return (
            self._seen == CALIBRATION_VELOCITIES and self._again < MAX_CHANCE_REPEAT_FRACTION * CALIBRATION_VELOCITIES
        )

    def _goes_elsewhere(self, pose: ArrayLike, velocity: Array) -> bool:
        """Whether a pose is elsewhere than the velocity says that came since the first one."""
        there = usable(pose)
        if not np.isfinite(there + velocity).all():
            return False
        if self._began is None:
            self._began = self._time, there
            return False
        since, first = self._began
        off = there - first - (self._time - since) * velocity
        return bool(math.hypot(off[0], off[1]) > MAX_WAY_ERROR or abs(wrapped(off[2])) > MAX_WAY_ERROR)


def _moves(motion: Motion) -> bool:
    return any(abs(speed) > MIN_MOVING_SPEED for speed in motion.velocity.tolist())
