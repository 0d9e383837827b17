"""Poses and velocities that jump: for a few rows, as a tracker that loses its markers does, or for good, as a map that
is put right under a cart does."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ..suspicion import Suspicion, listing
from .steps import step_of

FAR = 8.0
"""Times the median distance from what is foretold, in all and around: 5.4 standard deviations of white noise, which it
exceeds once in 15 million rows."""
FAR_SPEED = 16.0
"""The same for velocities: a push makes kinks in them, which straight lines across foretell badly."""
ACROSS = (2, 3, 5, 6, 8)
"""Rows to both sides, of which each pair foretells the middle; three rows that are off spoil two of the five."""
LONGEST, EDGE = 3, 0.65
"""Rows that are off together, at most; share of the size that the rows at their edges make at once."""
SIDE = 7
"""Rows before and after of which medians tell a lasting jump; three rows that are off don't move them."""
COARSE = 2.5
"""Steps of a sensor's grid: from one row to the next rounding alone makes two."""
MOST = 0.02
"""Of the rows: what happens more often is no accident but the sensor's noise."""


@dataclass(frozen=True)
class Jumps:
    """Rows (n,) that are off for a few rows, by how much at most; and rows with which a shifted stretch begins, by how
    much each (n,), 0 elsewhere."""

    off: np.ndarray
    size: float
    shift: Array


def jumps_of(column: Array, time: Array, far: float = FAR) -> Jumps:
    """Of a column (n,) at times (n,), NaN where missing; `far` as `FAR`."""
    there = np.flatnonzero(np.isfinite(column))
    off, shift = np.zeros(len(column), dtype=bool), np.zeros(len(column))
    values, t = column[there], time[there]
    if len(values) <= 4 * SIDE:
        return Jumps(off, 0.0, shift)
    grid = COARSE * (step_of(values) or 0.0)
    shift[there] = _lasting(values, t, grid)
    beside = _beside(values - np.cumsum(shift[there]), t)
    found = _far(beside, grid, ACROSS[0] + ACROSS[-1], far) & _sharp(beside)
    off[there] = found
    return Jumps(off, float(np.abs(beside[found]).max(initial=0.0)), shift)


def _far(beside: Array, grid: float, reach: int, times: float = FAR) -> np.ndarray:
    """Which of what is left (n,) are further than noise goes, in all and for `reach` rows around, and the furthest
    there."""
    size = np.abs(beside)
    usual = float(np.median(size))
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(size, reach, constant_values=usual), 2 * reach + 1)
    noise = np.maximum(usual, np.median(windows, axis=1))
    far = (size > np.maximum(times * noise, max(grid, np.finfo(float).tiny))) & (size > 0.6 * windows.max(axis=1))
    return far if far.mean() < MOST else np.zeros_like(far)


def _sharp(beside: Array) -> np.ndarray:
    """Which of what is left (n,) come and go at once, within three rows: a change of speed comes over several."""
    steps = np.abs(np.diff(beside, prepend=0.0, append=0.0))
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(steps, (LONGEST - 1, LONGEST - 1)), LONGEST).max(axis=1)
    before, after = windows[: len(beside)], windows[LONGEST : LONGEST + len(beside)]
    return np.asarray(np.minimum(before, after) > EDGE * np.abs(beside))


def _beside(values: Array, time: Array) -> Array:
    """Values (n,) less the median of what pairs of rows at equal distances foretell; 0 at the ends."""
    n, reach = len(values), ACROSS[-1]
    inner = np.arange(reach, n - reach)
    told = []
    for k in ACROSS:
        before, after = inner - k, inner + k
        share = (time[inner] - time[before]) / (time[after] - time[before])
        told.append(values[before] + share * (values[after] - values[before]))
    found = np.zeros(n)
    found[inner] = values[inner] - np.median(told, axis=0)
    return found


def _lasting(values: Array, time: Array, grid: float) -> Array:
    """By how much a stretch is shifted that begins with each row (n,), 0 where none does: medians of the rows before
    and after, each carried on at its own speed."""
    n = len(values)
    rows = np.lib.stride_tricks.sliding_window_view(values, SIDE)
    times = np.lib.stride_tricks.sliding_window_view(time, SIDE)
    third = SIDE // 3
    speed = (rows[:, -third:].mean(axis=1) - rows[:, :third].mean(axis=1)) / (
        times[:, -third:].mean(axis=1) - times[:, :third].mean(axis=1)
    )
    level, middle = np.median(rows, axis=1), times.mean(axis=1)
    before, after = slice(0, n - 2 * SIDE + 1), slice(SIDE, None)
    at = (time[SIDE - 1 : n - SIDE] + time[SIDE : n - SIDE + 1]) / 2
    change = level[after] + speed[after] * (at - middle[after]) - level[before] - speed[before] * (at - middle[before])
    far = _far(change, grid, 2 * SIDE)
    first = np.arange(SIDE, n - SIDE + 1)
    one_step = (
        values[first] - values[first - 1] - 0.5 * (speed[after] + speed[before]) * (time[first] - time[first - 1])
    )
    far &= (np.abs(one_step - change) < 0.3 * np.abs(change)) & (np.abs(one_step) > grid)
    found = np.zeros(n)
    found[first[far]] = one_step[far]
    return found


def _columns(log: RunLog) -> Iterator[tuple[str, str, str, Array]]:
    """Where, name, unit and column (n,)."""
    heading = log.pose[:, 2].copy()
    known = np.isfinite(heading)
    heading[known] = np.unwrap(heading[known])
    yield "pose", "x", "m", log.pose[:, 0]
    yield "pose", "y", "m", log.pose[:, 1]
    yield "heading", "theta", "rad", heading
    if log.velocity is not None:
        for name, unit, column in zip(("vx", "vy", "omega"), ("m/s", "m/s", "rad/s"), log.velocity.T, strict=True):
            yield "velocity", name, unit, column


def jumps(log: RunLog) -> tuple[Suspicion, ...]:
    """Of poses and velocities."""
    told = []
    for where, name, unit, column in _columns(log):
        found = jumps_of(column, log.time, FAR_SPEED if where == "velocity" else FAR)
        if found.off.any():
            words = (
                f"{int(found.off.sum())} of {len(log)} values of {name} are off for a few rows, by {found.size:.3g} "
                f"{unit} at most ({_times(log, found.off)}); leave those cells blank"
            )
            told.append(Suspicion("jumps", where, 0.95, found.size, words))
        if where != "velocity" and found.shift.any():
            size = float(np.abs(found.shift).max())
            words = (
                f"{name} is shifted by {size:.3g} {unit} at most from one row to the next and stays so "
                f"({_times(log, found.shift != 0)}); cut the log there, or take poses that no map corrects"
            )
            told.append(Suspicion("jumps", where, 0.95, size, words))
    return tuple(told)


def _times(log: RunLog, which: np.ndarray) -> str:
    return "at " + listing([f"{t:.2f} s" for t in log.time[which]])


def without_jumps(log: RunLog) -> RunLog:
    """The log, with poses and velocities that are off for a few rows as missing samples."""
    off = {False: np.zeros(len(log), dtype=bool), True: np.zeros(len(log), dtype=bool)}
    for where, _, _, column in _columns(log):
        is_speed = where == "velocity"
        off[is_speed] |= jumps_of(column, log.time, FAR_SPEED if is_speed else FAR).off
    velocity = None if log.velocity is None else np.where(off[True][:, None], np.nan, log.velocity)
    return replace(log, pose=np.where(off[False][:, None], np.nan, log.pose), velocity=velocity)
