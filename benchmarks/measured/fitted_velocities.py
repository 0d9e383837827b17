"""Velocities made from poses by parabolas that slide along them (Savitzky and Golay, 1964), at any times."""

from __future__ import annotations

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.frames import Array

HALF_WIDTH = 0.06
"""s: what hands and drives do takes a tenth of a second or longer."""
FEWEST = 2
"""Rows on each side."""


def fitted_velocities(time: Array, pose: Array) -> Array:
    """(n, 3) in {s}: the slopes, at each row, of the parabola through it and its neighbours; at the ends, through those
    that there are."""
    n = len(time)
    k = max(FEWEST, round(HALF_WIDTH / float(np.median(np.diff(time)))))
    if n < 2 * k + 1:
        raise DataError(f"velocities can't be made from {n} rows; {2 * k + 1} are needed")
    near = np.clip(np.arange(n) - k, 0, n - 2 * k - 1)[:, None] + np.arange(2 * k + 1)
    away = (time[near] - time[:, None]) / HALF_WIDTH
    powers = away[..., None] ** np.arange(3)
    places = np.column_stack([pose[:, :2], np.unwrap(pose[:, 2])])[near]
    found = np.linalg.solve(powers.mT @ powers, powers.mT @ places)
    return np.asarray(found[:, 1] / HALF_WIDTH)
