"""Numbers that no cart's log holds: nothing can be worked out by them, or they are of another unit of length. How fast
the cart would be tells of that, and no other sensor has to be believed.
"""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.logs import RunLog

from .suspicion import Suspicion

MAX_LOG_VALUE = 1e9
"""m, rad, m/s, N, N·m, and s of a whole log: beyond, no number is in SI units."""
MAX_CART_SPEED, POSITION_NOISE_SIGMAS = 40.0, 10.0
"""m/s that no cart goes from one row to the next; deviations of a position, which are none of its speed."""
POSITION_UNITS = {"mm": 0.001, "cm": 0.01, "inches": 0.0254, "feet": 0.3048}
USUAL_CART_SPEED = 0.5
"""m/s of a cart that is pushed."""
SPEED_INTERVAL, SPEED_QUANTILE = 1.0, 0.9
"""s over which speeds are taken, and the share of them that is slower than the one that counts: poses may jump."""


def check_sizes(log: RunLog) -> None:
    """Refuses them."""
    parts = {"pose": log.pose, "velocity": log.velocity}
    for name, arm in log.arms.items():
        parts |= {f"contact point of arm {name}": arm.contact, f"wrench of arm {name}": arm.wrench}
    for what, values in parts.items():
        sizes = np.zeros((1, 1)) if values is None else np.abs(np.where(np.isfinite(values), values, 0.0))
        if (sizes > MAX_LOG_VALUE).any():
            row = int(np.argmax(sizes.max(axis=1)))
            raise DataError(
                f"{log.name}: the {what} at t = {log.time[row]:g} s is beyond {MAX_LOG_VALUE:g}; look for numbers that "
                "are not in SI units"
            )
    if log.duration > MAX_LOG_VALUE:
        raise DataError(f"{log.name}: it lasts for {log.duration:.3g} s; look for times that are not in seconds")


def check_jumps(log: RunLog, noise: float) -> None:
    """Refuses poses that jump beyond their noise (m)."""
    seen = np.flatnonzero(np.isfinite(log.pose[:, :2]).all(axis=1))
    if len(seen) < 2:
        return
    step = np.hypot(*np.diff(log.pose[seen, :2], axis=0).T)
    spent = np.diff(log.time[seen])
    speed = np.maximum(step - POSITION_NOISE_SIGMAS * noise, 0.0) / spent
    if speed.max() > MAX_CART_SPEED:
        at = int(np.argmax(speed))
        raise DataError(
            f"{log.name}: the cart jumps by {step[at]:.2g} m in {spent[at]:.2g} s at t = {log.time[seen][at]:.10g} s; "
            "cut the log there, stamp rows when they are measured, and look for numbers that are not in SI units"
        )


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
