"""What bumps see of poses and of the velocities that were recorded beside them.

With velocities v(t) = gain * v_true(t - lag), each bump phi sees

    ∫ phi dx = 1/gain ∫ phi(t - lag) v dt + lever terms,

where the lever (2 columns) is the place of the velocity's point in the pose's frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array

from ..weak_form import Bumps
from .track import MEASURED, Track

WIDTH = 0.8
"""s: of the bumps; starts and stops take about as long."""
CLUSTER = 3.0
"""s: of stretches that are taken for independent: longer than noise remembers, short beside a log."""
FEWEST = 8
"""Rows of a fit."""


@dataclass(frozen=True)
class VelocityRows:
    """Rates (m, d) recorded at times (m,); what bumps see of their poses, (d, k); levers (d, k, l)."""

    time: Array
    rate: Array
    seen: Array
    levers: Array
    bumps: Bumps
    covered: np.ndarray

    def at(self, lag: float) -> tuple[Array, Array, np.ndarray] | None:
        """For velocities that are `lag` s late: what is seen (n,) and its columns by 1/gain and by the lag (n, 2),
        both beside levers, and the stretch of each row (n,). None where rows are too few."""
        sums = self.bumps.on(self.time, lag)
        kept = sums.covered & self.covered
        if kept.sum() < FEWEST:
            return None
        value, slope = sums.integral(self.rate).T, -sums.slope_integral(self.rate).T
        columns = np.stack([value, slope], axis=-1)[:, kept].reshape(-1, 2)
        both = np.column_stack([self.seen[:, kept].ravel(), columns])
        if self.levers.shape[2]:
            levers = self.levers[:, kept].reshape(len(both), -1)
            both -= levers @ np.linalg.lstsq(levers, both, rcond=1e-9)[0]
        cluster = CLUSTER * self.bumps.width / WIDTH
        stretch = ((self.bumps.centres - self.bumps.centres[0]) / cluster).astype(int)[kept]
        return both[:, 0], both[:, 1:], np.tile(stretch, len(self.seen))


def linear_rows(track: Track, time: Array, velocity: Array) -> VelocityRows | None:
    """Of linear velocities (m, 2) in {s} at times (m,), NaN where missing; None where there is too little."""
    rows = _rows(track, time, velocity, [track.x, track.y])
    if rows is None:
        return None
    sums, one = rows.bumps.on(track.time), np.ones_like(track.time)
    c, s = np.cos(track.heading), np.sin(track.heading)
    levers = [[sums.along(one, p) for p in lever] for lever in ((c, s), (-s, c))]
    return VelocityRows(rows.time, rows.rate, rows.seen, np.stack(levers, axis=-1), rows.bumps, rows.covered)


def yaw_rows(track: Track, time: Array, rate: Array) -> VelocityRows | None:
    """Of yaw rates (m,)."""
    return _rows(track, time, rate[:, None], [track.heading])


def _rows(track: Track, time: Array, rate: Array, positions: list[Array]) -> VelocityRows | None:
    there = np.isfinite(rate).all(axis=1)
    if there.sum() < 2 * MEASURED or len(track.time) < 2 * MEASURED:
        return None
    step = float(np.median(np.diff(time[there])))
    bumps = Bumps.over(track.time, max(track.width(WIDTH), MEASURED * step))
    if len(bumps.centres) < FEWEST:
        return None
    sums, one = bumps.on(track.time), np.ones_like(track.time)
    seen = np.array([sums.along(one, position) for position in positions])
    return VelocityRows(time[there], rate[there], seen, np.zeros((*seen.shape, 0)), bumps, sums.covered)
