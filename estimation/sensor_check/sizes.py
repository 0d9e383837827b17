"""Numbers that no cart's log holds, by which nothing can be worked out."""

from __future__ import annotations

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.logs import RunLog

MAX_LOG_VALUE = 1e9
"""m, rad, m/s, N, N·m, and s of a whole log: beyond, no number is in SI units."""
MAX_CART_SPEED, POSITION_NOISE_SIGMAS = 40.0, 10.0
"""m/s that no cart goes from one row to the next; deviations of a position, which are none of its speed."""


def check_sizes(log: RunLog) -> None:
    """Refuses them."""
    parts = {"pose": log.pose, "velocity": log.velocity}
    for name, arm in log.arms.items():
        parts |= {f"contact point of arm {name}": arm.contact, f"wrench of arm {name}": arm.wrench}
    for what, values in parts.items():
        if values is not None and (np.abs(values[np.isfinite(values)]) > MAX_LOG_VALUE).any():
            row = int(np.argmax(np.nanmax(np.abs(np.where(np.isfinite(values), values, 0.0)), axis=1)))
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
    speed = np.maximum(step - POSITION_NOISE_SIGMAS * noise, 0.0) / np.diff(log.time[seen])
    if speed.max() > MAX_CART_SPEED:
        at = int(np.argmax(speed))
        raise DataError(
            f"{log.name}: the cart jumps by {step[at]:.2f} m at t = {log.time[seen][at]:g} s; cut the log there, and "
            "look for numbers that are not in SI units"
        )
