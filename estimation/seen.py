"""What a measurement says of the motion, as one row of numbers; and what says nothing of motion, and of wrenches."""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.motion import Measurement

NOTHING_SEEN, NOTHING_FELT = np.full(6, np.nan), np.full(1, np.nan)


def seen_in(measurement: Measurement) -> Array:
    """Pose and velocity (6,), NaN where missing."""
    seen = np.empty(6)
    seen[:3] = np.nan if measurement.pose is None else measurement.pose
    seen[3:] = np.nan if measurement.velocity is None else measurement.velocity
    return seen
