"""`Track`: the poses of a log that are there, without jumps and repeats, and what bumps see of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ..weak_form import Bumps, Sums

LOCAL = 0.4
"""s: width of the bumps whose mean speeds tell drags and directions; carts change speed more slowly."""
MEASURED = 12
"""Rows within a bump, at least."""
WIDEST = 2.0
"""Times the width that is wanted: over longer bumps what a check looks for is gone."""


@dataclass(frozen=True)
class Track:
    """Times (n,), places (n,) in {s} and headings (n,), unwrapped; all finite."""

    time: Array
    x: Array
    y: Array
    heading: Array

    @classmethod
    def of(cls, log: RunLog) -> Track:
        there = np.isfinite(log.pose).all(axis=1)
        x, y, heading = log.pose[there].T
        return cls(log.time[there], x, y, np.unwrap(heading))

    @property
    def step(self) -> float:
        """s between rows, usually."""
        return float(np.median(np.diff(self.time))) if len(self.time) > 1 else np.inf

    def is_fast(self, wanted: float) -> bool:
        """Whether rows come fast enough for bumps of about a width, s."""
        return self.width(wanted) <= WIDEST * wanted

    def width(self, wanted: float) -> float:
        """Of bumps, s: what is wanted, or as many rows as a measurement takes."""
        return max(wanted, MEASURED * self.step)

    def headed(self, time: Array) -> Array:
        """Heading (m,) at other times (m,)."""
        return np.interp(time, self.time, self.heading)

    def along(self, sums: Sums) -> tuple[Array, Array]:
        """∫ phi u dt and ∫ phi w dt (k,) of the speeds along and across {b}'s x."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        return sums.along(c, self.x) + sums.along(s, self.y), sums.along(c, self.y) - sums.along(s, self.x)

    def accelerating(self, sums: Sums) -> tuple[Array, Array, Array]:
        """∫ phi u' dt, ∫ phi w' dt and ∫ phi r' dt (k,)."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        forward = sums.slope_along(c, self.x) + sums.slope_along(s, self.y)
        sideways = sums.slope_along(c, self.y) - sums.slope_along(s, self.x)
        return -forward, -sideways, -sums.slope_along(np.ones_like(self.x), self.heading)

    def speeds(self, time: Array) -> Array:
        """Local means (m, 3) of u, w and r at times (m,)."""
        width = self.width(LOCAL)
        bumps = Bumps(np.arange(self.time[0], self.time[-1] + width / 8, width / 8), width)
        sums = bumps.on(self.time)
        one = np.ones_like(self.time)
        weight = np.maximum(sums.integral(one), 1e-12)
        means = np.column_stack([*self.along(sums), sums.along(one, self.heading)]) / weight[:, None]
        return np.column_stack([np.interp(time, bumps.centres, column) for column in means.T])
