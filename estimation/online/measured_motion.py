"""What a measurement says of the motion, as one row of numbers; and what says nothing of motion, wrenches, contacts."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.checks import MAX_NUMBER
from cartgrasp.frames import Array
from cartgrasp.motion import Measurement

NO_MOTION, NO_WRENCHES = np.full(6, np.nan), np.full(1, np.nan)


def usable(values: ArrayLike) -> Array:
    """As floats, NaN where squares may overflow."""
    numbers = np.array(values, dtype=float)
    numbers[np.abs(numbers) > MAX_NUMBER] = np.nan
    return numbers


def is_contact(told: Sequence[float] | Array) -> bool:
    """Whether a contact (3,) says where in the plane an arm holds; its height may be missing."""
    return math.isfinite(told[0]) and math.isfinite(told[1])


class MeasuredMotion:
    """Room for what is seen, which is filled anew for each measurement."""

    def __init__(self) -> None:
        self._whole = np.empty(6)
        self._pose, self._velocity = self._whole[:3], self._whole[3:]
        self.is_whole = False
        """Whether nothing of the last measurement is missing."""

    def of(self, measurement: Measurement) -> Array:
        """Pose and velocity (6,), NaN where missing."""
        pose, velocity = measurement.pose, measurement.velocity
        self._pose[:] = np.nan if pose is None else pose
        self._velocity[:] = np.nan if velocity is None else velocity
        x, y, yaw, along, across, turn = map(abs, self._whole.tolist())
        most = MAX_NUMBER
        motion = along <= most and across <= most and turn <= most
        self.is_whole = motion and x <= most and y <= most and yaw <= most
        if not self.is_whole:
            self._whole[np.abs(self._whole) > most] = np.nan
        return self._whole
