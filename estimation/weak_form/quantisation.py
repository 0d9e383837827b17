"""Poses that a sensor tells in steps: at the moment at which a reading goes from one value to the next, the truth is
half-way between them, known far better than in between (Merry, van de Molengraft and Steinbuch, 2013, on encoders).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cartgrasp.frames import Array, wrap_angle
from cartgrasp.logs import RunLog

from ..log_noise.resolution import ROUND_OFF_TOLERANCE, resolution

WHOLE_STEP_TOLERANCE, MIN_WHOLE_STEP_FRACTION, MAX_COUNTED_STEPS = 0.1, 0.95, 5.0
"""How far a change may be from a whole number of steps, in steps; and the share of changes that are no farther. Changes
of more steps than the last are not asked, since a step that is told roughly adds up."""


def dequantised(log: RunLog) -> RunLog:
    """The log, with poses that come in steps on straight lines between the moments at which they change; as they are
    where the motion turns within a step."""
    pose = log.pose.copy()
    seen = np.isfinite(pose).all(axis=1)
    pose[seen, 2] = np.unwrap(pose[seen, 2])
    for i in range(3):
        pose[seen, i] = _smoothed(log.time[seen], pose[seen, i])
    pose[seen, 2] = wrap_angle(pose[seen, 2])
    return replace(log, pose=pose)


def _smoothed(time: Array, values: Array) -> Array:
    """Values (n,) within half a step of what was recorded; as they are where they come in no steps."""
    step = resolution(values)
    last = np.flatnonzero(np.abs(np.diff(values)) > ROUND_OFF_TOLERANCE)
    if len(last) < 2 or not _in_steps(np.diff(values)[last], step):
        return values
    moments, places = (time[last] + time[last + 1]) / 2, (values[last] + values[last + 1]) / 2
    after = np.searchsorted(moments, time)
    goes_on = np.append(np.insert(np.diff(places) != 0.0, 0, False), False)[after]
    found = np.where(goes_on, np.interp(time, moments, places), values)
    return np.asarray(np.clip(found, values - step / 2, values + step / 2))


def _in_steps(changes: Array, step: float) -> bool:
    """Whether changes (n,) are whole numbers of steps."""
    counts = np.abs(changes) / step
    few = counts[counts < MAX_COUNTED_STEPS]
    return bool(len(few) and np.mean(np.abs(few - np.rint(few)) < WHOLE_STEP_TOLERANCE) > MIN_WHOLE_STEP_FRACTION)
