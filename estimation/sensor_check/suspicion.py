"""`Suspicion`: what a log's sensors seem to do, how likely it is, and what would mend it."""

from __future__ import annotations

from dataclasses import dataclass

KINDS = ("sign", "unit", "axes", "lag", "scale", "frame", "offset", "repeated", "quantised", "jumps", "holes")
REFUSED = ("sign", "unit", "axes", "frame")
"""Kinds with which no estimate means anything."""
SURE = 0.9
"""Probability from which one of `REFUSED` stops a command, and the others are put right (`contract/cli.md`)."""
TOLD = 0.1
"""Less likely ones are not worth a line: what is told wrongly more often than once in ten is no longer read."""


@dataclass(frozen=True)
class Suspicion:
    """`where` is an arm's name, or `pose`, `heading`, `velocity`, `yaw_rate`, `time`. `factor` is the number that the
    words speak of: what recorded values are multiplied by to be right (`unit`, `sign`), are too large by (`scale`), the
    lag (s), a step or a wave's period (in the column's unit, m), rows for each fresh one; None where there is none."""

    kind: str
    where: str
    probability: float
    factor: float | None
    words: str

    @property
    def is_refused(self) -> bool:
        return self.kind in REFUSED and self.probability >= SURE


def listing(items: list[str], most: int = 4) -> str:
    """`a, b and 3 more`."""
    more = f" and {len(items) - most} more" if len(items) > most else ""
    return ", ".join(items[:most]) + more
