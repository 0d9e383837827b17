"""Numbers that no cart's log holds, by which nothing can be worked out."""

from __future__ import annotations

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.logs import RunLog

LARGEST = 1e9
"""m, rad, m/s, N, N·m, and s of a whole log: beyond, no number is in SI units."""


def check_sizes(log: RunLog) -> None:
    """Refuses them."""
    parts = {"pose": log.pose, "velocity": log.velocity}
    for name, arm in log.arms.items():
        parts |= {f"contact point of arm {name}": arm.contact, f"wrench of arm {name}": arm.wrench}
    for what, values in parts.items():
        if values is not None and (np.abs(values[np.isfinite(values)]) > LARGEST).any():
            row = int(np.argmax(np.nanmax(np.abs(np.where(np.isfinite(values), values, 0.0)), axis=1)))
            raise DataError(
                f"{log.name}: the {what} at t = {log.time[row]:g} s is beyond {LARGEST:g}; look for numbers that are "
                "not in SI units"
            )
    if log.duration > LARGEST:
        raise DataError(f"{log.name}: it lasts for {log.duration:.3g} s; look for times that are not in seconds")
