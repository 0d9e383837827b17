"""When a residual begins to be larger or smaller: change points, by ruptures' exact search."""

from __future__ import annotations

from typing import Any

import numpy as np
import ruptures

from cartgrasp.frames import Array

CHANGE_POINT_PENALTY = 3.0
"""Penalty of a change, times log n, in chi-squared: two for its place and its size, by Schwarz's criterion, and one for
the search."""
MAX_CHANGE_POINT_PLACES = 400
"""Most places that are looked at: in longer residuals every second, third, ... one."""


def changes(standard: Array) -> list[int]:
    """Places at which the size of a residual in standard deviations (n,) changes."""
    if len(standard) < 2:
        return []
    search = ruptures.Pelt(custom_cost=_Size(), min_size=1, jump=1 + len(standard) // MAX_CHANGE_POINT_PLACES)
    ends = search.fit(standard[:, None]).predict(CHANGE_POINT_PENALTY * np.log(len(standard)))
    return [int(place) for place in ends[:-1]]


class _Size(ruptures.base.BaseCost):  # type: ignore[misc]
    """Cost of a stretch with a size of its own about zero, but none below noise: minus twice the log of the
    likelihood."""

    model, min_size = "size", 1

    def fit(self, signal: Array) -> _Size:
        self.signal: Any = signal
        self.squares = np.append(0.0, np.cumsum(signal[:, 0] ** 2))
        return self

    def error(self, start: int, end: int) -> float:
        n, squares = end - start, float(self.squares[end] - self.squares[start])
        variance = max(squares / n, 1.0)
        return n * float(np.log(variance)) + squares / variance
