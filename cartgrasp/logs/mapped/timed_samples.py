"""Samples on the log's time."""

from __future__ import annotations

from dataclasses import dataclass

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


def step_figures(time: Array) -> dict[str, float]:
    """What a processing step says of the steps between times (n,), s, if there are any."""
    steps = np.diff(time)
    return {"median_step_s": float(np.median(steps)), "largest_gap_s": float(steps.max())} if len(steps) else {}
