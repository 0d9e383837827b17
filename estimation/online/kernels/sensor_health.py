"""How each sensor does, sample by sample: rows of a table (3, 4), of pose, velocity and wrench. A row is the last
usable sample's time, its normalised square over the gate beyond which it counts less, the share of the last samples
that were beyond it, and 1 where nothing has come for too long."""

from __future__ import annotations

import math

from cartgrasp.frames import Array

SENSOR_TIMEOUT = 0.5
"""s without a usable sample after which a sensor that spoke before is missed."""
MAX_OUTLIER_FRACTION, OUTLIER_SAMPLE_WEIGHT = 0.1, 0.05
"""Share of the last samples beyond their gate from which on outliers are reported; and the weight of a new sample in
it."""
POSE_MISSED, WRENCH_MISSED, OUTLYING = 1, 2, 4
"""What is said of them all, as a sum."""


def noted(table: Array, time: float, ratios: Array) -> int:
    """Updates the table after a sample of each sensor; returns what is said. A ratio that is not finite is of a sample
    that could not be used."""
    for i in range(len(table)):
        note(table[i], time, ratios[i])
    return said_of(table)


def note(row: Array, time: float, ratio: float) -> None:
    if math.isfinite(ratio):
        row[0], row[1], row[3] = time, ratio, 0.0
        row[2] += OUTLIER_SAMPLE_WEIGHT * ((1.0 if ratio > 1.0 else 0.0) - row[2])
    else:
        row[3] = 1.0 if math.isfinite(row[0]) and time - row[0] > SENSOR_TIMEOUT else 0.0


def said_of(table: Array) -> int:
    said = (POSE_MISSED if table[0, 3] > 0.0 else 0) + (WRENCH_MISSED if table[2, 3] > 0.0 else 0)
    return said + (OUTLYING if table[0, 2] > MAX_OUTLIER_FRACTION or table[1, 2] > MAX_OUTLIER_FRACTION else 0)
