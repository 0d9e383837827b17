"""How much later, and larger, recorded velocities are than poses say.

With velocities v(t) = gain * v_true(t - lag), each window sees

    ∫ phi dx = 1/gain ∫ phi(t - lag) v dt + lever terms,

where the lever is the place of the velocities' point in the poses' frame. Solved for both by Gauss and Newton. Of a
speed that fades evenly a lag looks like a scale, and noise alone would tell them apart: then neither is told.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array

from ..log_noise.log_noise import white_noise
from .evidence import independent_rows
from .windows import MIN_WINDOWS, Sums, Track, Windows

MAX_VELOCITY_LAG, LAG_GRID_STEP = 0.4, 0.1
"""s: of lags that are looked for, and between those with which a search begins; half a start or stop."""
MAX_LAG_ITERATIONS, LAG_TOLERANCE = 12, 1e-6
"""Most rounds of Gauss and Newton; change of the lag (s) below which they end."""
MAX_LAG_NOISE_FRACTION = 0.1
"""Share of what tells lags from scales that noise may make."""
MIN_EXPLAINED_FRACTION = 0.5
"""Least share of what poses do that velocities must explain before their clock can be told."""


@dataclass(frozen=True)
class Clock:
    """Lag (s) and gain of velocities against poses, with standard deviations."""

    lag: float
    lag_std: float
    gain: float
    gain_std: float


@dataclass(frozen=True)
class Rates:
    """Rates (m, d) at rows of a log (n,), m of them whole, and times (m,), beside what windows see of their poses
    (d, k) and of levers (d, k, q)."""

    windows: Windows
    there: np.ndarray
    time: Array
    rate: Array
    seen: Array
    levers: Array
    covered: np.ndarray

    @classmethod
    def of(cls, track: Track, time: Array, rate: Array) -> Rates | None:
        """The rates from linear velocities (m, 2) in {s}, or yaw rates (m, 1), NaN where missing; None where there are
        too few."""
        there = np.asarray(np.isfinite(rate).all(axis=1))
        windows = Windows.over(track.time, time[there])
        if windows is None:
            return None
        sums = windows.on(track.time)
        if rate.shape[1] == 1:
            seen = sums.along(track.heading)[None]
            levers = np.zeros((*seen.shape, 0))
        else:
            c, s = np.cos(track.heading), np.sin(track.heading)
            seen = np.array([sums.along(track.x), sums.along(track.y)])
            levers = np.array([[sums.along(c), -sums.along(s)], [sums.along(s), sums.along(c)]]).swapaxes(1, 2)
        return cls(windows, there, time[there], rate[there], seen, levers, sums.covered)

    def read_as(self, rate: Array) -> Rates:
        """The same rows and poses with other rates (n, d)."""
        return replace(self, rate=rate[self.there])

    def by(self, sums: Sums) -> tuple[Array, Array, float] | None:
        """What is seen (n,), its columns by 1/gain and by lag (n, 2), both beside levers, and what noise of variance 1
        adds to the latter's sum of squares. None where windows are too few."""
        kept = sums.covered & self.covered
        if kept.sum() < MIN_WINDOWS:
            return None
        columns = np.stack([sums.integral(self.rate).T, sums.rate(self.rate).T], axis=-1)[:, kept].reshape(-1, 2)
        both = np.column_stack([self.seen[:, kept].ravel(), columns])
        levers = self.levers[:, kept].reshape(len(both), -1)
        if levers.shape[1]:
            both = both - levers @ np.linalg.lstsq(levers, both, rcond=1e-9)[0]
        return both[:, 0], both[:, 1:], sums.rate_noise(kept)


LagFit = tuple[float, Array, Array]
"""A lag (s), with what is seen and what velocities say (n,)."""


def best_lags(readings: Sequence[Rates]) -> list[LagFit | None]:
    """The lag of a coarse grid that leaves least, for rates at the same rows that are read in several ways."""
    tried: list[list[tuple[float, LagFit]]] = [[] for _ in readings]
    for lag in np.arange(-MAX_VELOCITY_LAG, MAX_VELOCITY_LAG + LAG_GRID_STEP / 2, LAG_GRID_STEP).tolist():
        sums = readings[0].windows.on(readings[0].time, lag)
        for rates, own in zip(readings, tried, strict=True):
            found = rates.by(sums)
            if found is not None:
                seen, z = found[0], found[1][:, 0]
                along, size = max(float(seen @ z), 0.0), max(float(z @ z), 1e-300)
                own.append(((float(seen @ seen) - along**2 / size) / len(seen), (lag, seen, z)))
    return [min(own, key=lambda one: one[0])[1] if own else None for own in tried]


def clock(rates: Rates | None) -> Clock | None:
    """None where motion and log are too little to tell, or velocities are of something else."""
    start = None if rates is None else best_lags([rates])[0]
    if rates is None or start is None:
        return None
    lag, variance = start[0], sum(white_noise(column) ** 2 for column in rates.rate.T)
    for _ in range(MAX_LAG_ITERATIONS):
        found = rates.by(rates.windows.on(rates.time, lag))
        if found is None:
            return None
        seen, columns, noise = found
        normal = columns.T @ columns
        if variance * noise >= MAX_LAG_NOISE_FRACTION * (normal[1, 1] - normal[0, 1] ** 2 / max(normal[0, 0], 1e-300)):
            return None
        values = np.linalg.solve(normal, columns.T @ seen)
        if values[0] <= 0:
            return None
        change = float(np.clip(values[1] / values[0], -LAG_GRID_STEP / 2, LAG_GRID_STEP / 2))
        lag += change
        if abs(change) < LAG_TOLERANCE:
            break
    left = seen - columns @ values
    if left @ left > (1 - MIN_EXPLAINED_FRACTION) * (seen @ seen) or abs(lag) > MAX_VELOCITY_LAG + LAG_GRID_STEP:
        return None
    rows = max(independent_rows(left) - 2, 1.0)
    std = np.sqrt(np.diag(np.linalg.inv(normal)) * (left @ left) / rows)
    return Clock(lag, float(std[1] / values[0]), float(1 / values[0]), float(std[0] / values[0] ** 2))
