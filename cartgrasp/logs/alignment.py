"""A log's wrenches brought back to when they happened, against the `time_delay` of its sensors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..frames import Array
from ..model import CartModel
from .run_log import ArmLog, RunLog

SAME_TIME = 1e-6
"""Of a step: an instant this near to a row is the row's."""


def aligned(log: RunLog, cart: CartModel) -> RunLog:
    """The log with each arm's wrenches as the cart's sensors recorded them `delay` later: linear between rows, NaN
    where the log has ended or a row beside is missing. Samples between rows have less noise than rows."""
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
    at = time + delay
    before = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)
    share = ((at - time[before]) / (time[before + 1] - time[before]))[:, None]
    between = (1.0 - share) * rows[before] + share * rows[before + 1]
    ends = np.where(np.abs(share) <= SAME_TIME, rows[before], np.where(share > 1.0 + SAME_TIME, np.nan, between))
    return np.where(np.abs(share - 1.0) <= SAME_TIME, rows[before + 1], ends)
