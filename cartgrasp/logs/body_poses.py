"""A log's poses and velocities brought to {b} from the frame that was tracked, against the `pose_offset` of its
sensors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..frames import Array
from ..model import CartModel
from ..tracked_point import carried, composed
from .run_log import RunLog


def at_body(log: RunLog, cart: CartModel) -> RunLog:
    """The log of {b}; a velocity without a heading takes that of the rows around it."""
    if not cart.pose_tb.any():
        return log
    velocity = log.velocity
    if velocity is not None:
        velocity = carried(velocity, _headings(log), cart.pose_tb[:2])
    return replace(log, pose=composed(log.pose, cart.pose_tb), velocity=velocity)


def _headings(log: RunLog) -> Array:
    """Headings at all rows (n,), rad, unwrapped; NaN where none is known."""
    known = np.isfinite(log.pose[:, 2])
    if not known.any():
        return np.full(len(log), np.nan)
    return np.asarray(np.interp(log.time, log.time[known], np.unwrap(log.pose[known, 2])))
