"""Samples on the log's time."""

from __future__ import annotations

from dataclasses import dataclass

from ...frames import Array

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
