"""Stretches of a log in which nobody saw the cart: what a smoother would put there is no motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cartgrasp.logs import RunLog
from cartgrasp.logs.run_log import ArmLog

from ..batch.motion_smoother import LONG_GAP


def without_holes(log: RunLog) -> RunLog:
    """The log without rows that have neither pose nor velocity, where they last for longer than a smoother may bridge,
    begin the log or end it."""
    seen = np.isfinite(log.pose).any(axis=1)
    if log.velocity is not None:
        seen |= np.isfinite(log.velocity).any(axis=1)
    times = log.time[seen]
    after = np.searchsorted(times, log.time)
    known = np.concatenate([[-np.inf], times, [np.inf]])
    kept = seen | (known[after + 1] - known[after] < LONG_GAP)
    if kept.all():
        return log
    arms = {name: ArmLog(arm.contact[kept], arm.wrench[kept]) for name, arm in log.arms.items()}
    velocity = None if log.velocity is None else log.velocity[kept]
    return replace(log, time=log.time[kept], pose=log.pose[kept], velocity=velocity, arms=arms)
