"""A log that is cut where the cart was hit, or its pose jumped, or nobody saw it: each part is a motion of its own."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.logs import ArmLog, RunLog
from cartgrasp.model import CartModel

from ..impacts.end_stops import end_stops
from ..impacts.impacts import Impact
from .balances import Balances

IMPACT_MARGIN = 0.05
"""Time (s) on each side of an impact, or a jump, that is left out: a touch, and how well it is timed."""
MIN_STOP_DISTANCE = 0.03
"""Distance (m) from a stop at which a cart leans on it, or hits it too softly to be seen."""
MAX_SEGMENT_POSE_GAP = 30.0
"""Time (s) without a pose, from which on a log is two: motion across it would only cost time."""
MIN_SEGMENT_DURATION = 1.0
"""Shortest part (s) that says anything."""


def segments(log: RunLog, cart: CartModel, impacts: Sequence[Impact], jumps: Iterable[float] = ()) -> list[Balances]:
    """The parts between impacts and times (s) at which the pose jumped, and away from stops, that are long enough."""
    return [Balances.of(part, cart) for part in segment_logs(log, impacts, jumps)]


def segment_logs(log: RunLog, impacts: Sequence[Impact], jumps: Iterable[float] = ()) -> list[RunLog]:
    """The parts of the log's rows that `segments` takes."""
    away = np.ones(len(log), dtype=bool)
    for time in (*(impact.time for impact in impacts), *jumps):
        away &= np.abs(log.time - time) > IMPACT_MARGIN
    for stop in end_stops(impacts):
        away &= ~(np.abs(log.pose[:, 0] - stop.position) < MIN_STOP_DISTANCE)
    edges = np.flatnonzero(np.diff(np.r_[False, away, False].astype(int)))
    parts = [
        rows_of(log, np.arange(first, last))
        for first, last in edges.reshape(-1, 2)
        if log.time[last - 1] - log.time[first] > MIN_SEGMENT_DURATION
    ]
    if not parts:
        raise DataError(
            f"{log.name}: it is hit so often, or its pose jumps, that no {MIN_SEGMENT_DURATION:g} s of it are left; "
            "record it between stops, with a tracker that keeps the cart"
        )
    return parts


def split_at_gaps(log: RunLog, hole: float) -> list[RunLog]:
    """Parts in which no more than a `hole` (s) is without a pose: what is not seen for long is no motion."""
    seen = np.flatnonzero(np.isfinite(log.pose).all(axis=1))
    ends = seen[np.flatnonzero(np.diff(log.time[seen]) > hole)]
    if not len(ends):
        return [log]
    edges = np.concatenate([[0], ends + 1, [len(log)]])
    return [rows_of(log, np.arange(first, last)) for first, last in pairwise(edges.tolist())]


def rows_of(log: RunLog, own: np.ndarray) -> RunLog:
    arms = {name: ArmLog(arm.contact[own], arm.wrench[own]) for name, arm in log.arms.items()}
    velocity = None if log.velocity is None else log.velocity[own]
    return replace(log, time=log.time[own], pose=log.pose[own], velocity=velocity, arms=arms)
