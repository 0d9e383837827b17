"""Poses that jump: a tracker that lost the cart and found it elsewhere.

Straight lines through the poses before a moment and through those after it miss each other there by how far the pose
jumped. A cart that is hit changes its speed, and they meet. So a jump is where they miss each other by far more than
noise, rounding and driving make of it, and a single step goes most of the way.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import maximum_filter1d

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ..log_noise.resolution import resolution
from .repeated_rows import MIN_LEAP_RATIO, without_repeated_rows
from .suspicion import Suspicion

JUMP_LINE_INTERVAL, MIN_JUMP_LINE_ROWS = 0.1, 4
"""s, and rows at least, through which a line goes."""
USUAL_MISS_QUANTILE, JUMP_MISS_RATIO = 0.9, 4.0
"""Share of all moments whose misses are usual; times that. It is 2.3 for white noise, and 3.8 at most in measured
logs."""
JUMP_STEP_RATIOS = 0.6, 1.5
"""What a step is of a jump, beside what noise makes of both."""
HIT_SPEED_CHANGE = {"pose": 1.0, "heading": 1.0}
"""m/s and rad/s: half of what a hit changes a speed by. It does within a step, at any moment of it."""
MAX_EVEN_SPAN_RATIO = 1.5
"""Times as long as usual that rows may take: lines through a hole say nothing."""


def jumps(log: RunLog) -> tuple[Suspicion, ...]:
    """`jumps` of places and headings."""
    told = []
    for where, (times, sizes) in _found(log).items():
        if len(times):
            most, unit = int(np.argmax(sizes)), {"pose": "m", "heading": "rad"}[where]
            often = "once" if len(times) == 1 else f"{len(times)} times"
            words = (
                f"{where}: jumps {often}, the farthest by {sizes[most]:.3g} {unit} at t = {times[most]:g} s, and "
                "goes on as before: a tracker that lost the cart; the log is taken apart there"
            )
            told.append(Suspicion("jumps", where, 0.99, float(sizes[most]), words, put_right=True))
    return tuple(told)


def jump_times(log: RunLog) -> Array:
    """The times (s) of the rows in which a pose or a heading jumped."""
    return np.unique(np.concatenate([times for times, _ in _found(log).values()]))


def _found(log: RunLog) -> dict[str, tuple[Array, Array]]:
    """Times (s) of rows that jumped, and sizes."""
    fresh = without_repeated_rows(log.pose, log.time)
    there = np.isfinite(fresh).all(axis=1)
    time, pose = log.time[there], fresh[there]
    tracks = {"pose": pose[:, :2], "heading": np.unwrap(pose[:, 2])[:, None]}
    return {where: _jumped(time, track, HIT_SPEED_CHANGE[where]) for where, track in tracks.items()}


def _jumped(time: Array, track: Array, hardest: float) -> tuple[Array, Array]:
    """Times (m,) and sizes (m,) of the jumps of a track (n, k)."""
    nothing = np.zeros(0), np.zeros(0)
    if len(time) < 2:
        return nothing
    period = float(np.median(np.diff(time)))
    rows = max(math.ceil(JUMP_LINE_INTERVAL / period), MIN_JUMP_LINE_ROWS)
    if len(time) <= 4 * rows:
        return nothing
    missed = np.linalg.norm(_misses(track, rows), axis=1)
    at = np.arange(rows - 1, len(time) - rows)
    even = time[at + rows] - time[at + 1 - rows] < MAX_EVEN_SPAN_RATIO * (2 * rows - 1) * period
    step = _beside(np.diff(track, axis=0), np.diff(time))[at]
    usual = float(np.quantile(missed[even], USUAL_MISS_QUANTILE)) if even.any() else math.inf
    coarse = MIN_LEAP_RATIO * float(np.linalg.norm([resolution(column) for column in track.T]))
    is_far = missed > max(JUMP_MISS_RATIO * usual, hardest * period, coarse)
    is_one = (step > JUMP_STEP_RATIOS[0] * missed) & (step < JUMP_STEP_RATIOS[1] * missed)
    peak = missed == maximum_filter1d(missed, 2 * rows + 1, mode="constant", cval=-math.inf)
    own = np.flatnonzero(even & is_far & is_one & peak)
    return time[at[own] + 1], missed[own]


def _misses(track: Array, rows: int) -> Array:
    """By how much (n - 2 rows + 1, k) lines through so many rows before and after a step miss each other in its
    middle."""
    x = np.arange(rows) - (rows - 1) / 2
    weight = 1 / rows + (rows / 2) * x / float(x @ x)  # of a line, half a step beyond its last row
    before = np.stack([np.convolve(column, weight[::-1], "valid") for column in track.T], axis=1)
    after = np.stack([np.convolve(column, weight, "valid") for column in track.T], axis=1)
    return np.asarray(after[rows:] - before[:-rows])


def _beside(step: Array, span: Array) -> Array:
    """How far (n,) steps (n, k) over spans (n,) are from what the two before and the two after would make of them."""
    rate = np.pad(step / span[:, None], ((2, 2), (0, 0)), mode="edge")
    around = np.array([rate[k : k + len(step)] for k in (0, 1, 3, 4)])
    return np.asarray(np.linalg.norm(step - np.median(around, axis=0) * span[:, None], axis=1))
