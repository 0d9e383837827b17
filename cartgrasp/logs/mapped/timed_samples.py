"""Samples on the log's time."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...frames import Array

MAX_MEASUREMENT = 1e9
"""m, rad, N: what is beyond is no measurement."""
MapPlace = tuple[str, ...]
"""In a map: ("pose",), ("velocity",), ("arms", NAME), ("arms", NAME, "contact")."""


@dataclass(frozen=True)
class TimedSamples:
    """Times (n,) in s from the log's zero, strictly increasing, and numbers (n, k); of what is static the last holds
    for ever."""

    time: Array
    numbers: Array
    is_static: bool = False

    def span(self) -> tuple[float, float]:
        return float(self.time[0]), float(self.time[-1])

    @property
    def usual_step(self) -> float:
        """The median, s; 0 where there is one sample."""
        return float(np.median(np.diff(self.time))) if len(self.time) > 1 else 0.0

    def is_slower(self, max_gap: float) -> bool:
        """Whether its usual step, to three digits, is longer, so that all would be gaps."""
        return float(f"{self.usual_step:.3g}") > max_gap

    def bridged(self, max_gap: float) -> float:
        """The longest gap that counts as `max_gap`, s. Stamps jitter; a sample that is missing takes a whole step."""
        return max_gap if self.is_slower(max_gap) else max_gap + self.usual_step / 2

    @property
    def whole(self) -> TimedSamples:
        """Those of which nothing is missing, if any: a slow sensor leaves blanks in a fast table."""
        there = np.isfinite(self.numbers).all(axis=1)
        return replace(self, time=self.time[there], numbers=self.numbers[there]) if there.any() else self


def step_figures(time: Array) -> dict[str, float]:
    """What a processing step says of the steps between times (n,), s, if there are any."""
    steps = np.diff(time)
    return {"median_step_s": float(np.median(steps)), "largest_gap_s": float(steps.max())} if len(steps) else {}
