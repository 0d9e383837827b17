"""Poses in another unit of length, by how fast the cart would be: no other sensor has to be believed for that."""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.logs import RunLog

from .sizes import MAX_CART_SPEED
from .suspicion import Suspicion

POSITION_UNITS = {"mm": 0.001, "cm": 0.01, "inches": 0.0254, "feet": 0.3048}
USUAL_CART_SPEED = 0.5
"""m/s of a cart that is pushed."""
SPEED_INTERVAL, SPEED_QUANTILE = 1.0, 0.9
"""s over which speeds are taken, and the share of them that is slower than the one that counts: poses may jump."""


def length_unit_suspicions(log: RunLog) -> tuple[Suspicion, ...]:
    """`unit` of x and y."""
    there = np.isfinite(log.pose).all(axis=1)
    time, place = log.time[there], log.pose[there, :2]
    later = np.searchsorted(time, time + SPEED_INTERVAL)
    begin = np.flatnonzero(later < len(time))
    if not len(begin):
        return ()
    way, spent = place[later[begin]] - place[begin], time[later[begin]] - time[begin]
    speed = float(np.quantile(np.linalg.norm(way, axis=1) / spent, SPEED_QUANTILE))
    if not speed > MAX_CART_SPEED:
        return ()
    name, factor = min(POSITION_UNITS.items(), key=lambda unit: abs(math.log(speed * unit[1] / USUAL_CART_SPEED)))
    words = f"x and y are in {name}: in m the cart would go at {speed:.3g} m/s; multiply them by {factor:g}"
    return (Suspicion("unit", "pose", 0.99, factor, words),)
