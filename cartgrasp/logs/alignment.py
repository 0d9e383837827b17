"""A log without what its sensors did to it: wrenches brought back to when they happened, against their `time_delay`;
poses and velocities brought to {b} from the frame that was tracked, against their `pose_offset`.

Each row takes the wrench that is nearest to the time at which its own was recorded: at most half a step off. Samples
mixed from two would share their noise with their neighbours, which those who learn from them take for steady force.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..frames import Array
from ..model import CartModel
from ..tracked_point import carried, composed
from .mapped.resampling import MAX_OFFSET_STEPS
from .run_log import ArmLog, RunLog, stamp_rounding

TIE_BREAK_FRACTION = 1e-6
"""Share of a step by which the earlier of two equally near samples is preferred, at least: rounding decides nothing."""


def aligned(log: RunLog, cart: CartModel) -> RunLog:
    """The log with each arm's wrenches as the cart's sensors recorded them `delay` later; NaN where there is none."""
    late = {name: cart.lateness(name) for name in log.arms}
    if not any(late.values()):
        return log
    arms = {
        name: ArmLog(arm.contact, _moved(log.time, arm.wrench, late[name])) if late[name] else arm
        for name, arm in log.arms.items()
    }
    return replace(log, arms=arms)


def _moved(time: Array, rows: Array, delay: float) -> Array:
    """Rows (n, k) as they are `delay` later."""
    if len(time) < 2:
        return np.full_like(rows, np.nan)
    step = np.median(np.diff(time))
    at = time + delay - max(TIE_BREAK_FRACTION * step, 2 * stamp_rounding(time))
    after = np.clip(np.searchsorted(time, at), 1, len(time) - 1)
    nearest = np.where(at - time[after - 1] <= time[after] - at, after - 1, after)
    return np.where(np.abs(time[nearest] - at)[:, None] < MAX_OFFSET_STEPS * step, rows[nearest], np.nan)


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
