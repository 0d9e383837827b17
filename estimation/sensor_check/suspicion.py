"""`Suspicion`: what a log's sensors seem to do, how likely it is, and what would mend it."""

from __future__ import annotations

from dataclasses import dataclass

SUSPICION_KINDS = ("sign", "unit", "axes", "frame", "lag", "scale", "offset", "repeated", "quantised", "jumps", "holes")
REFUSED_KINDS = ("sign", "unit", "axes", "frame")
"""Kinds with which no estimate means anything."""
REFUSAL_PROBABILITY = 0.9
"""Probability from which one of `REFUSED_KINDS` stops a command (`docs/command_line.md`)."""
REPORT_PROBABILITY, UNIT_REPORT_PROBABILITY = 0.5, 0.1
"""Less likely ones are not worth a line. Signs, axes and frames a log tells by itself, so they are likelier than not.
Of a unit often the mass alone speaks, whose guess may be off: what is wrong then is worth nine looks in vain."""


@dataclass(frozen=True)
class Suspicion:
    """`where` is an arm's name, or `pose`, `heading`, `velocity`, `yaw_rate`, `time`. `factor` is the number that the
    words speak of: what recorded values are multiplied by to be right (`unit`, `sign`), are too large by (`scale`), the
    lag (s), a step (in the column's unit), rows for each fresh one; None where there is none. `put_right`: fits and
    searches are of the log without it."""

    kind: str
    where: str
    probability: float
    factor: float | None
    words: str
    put_right: bool = False

    @property
    def is_refused(self) -> bool:
        return self.kind in REFUSED_KINDS and self.probability >= REFUSAL_PROBABILITY
