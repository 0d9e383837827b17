"""Rows that are missing: gaps in times that are else even. A log that comes evenly but seldom has none: it is slow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.errors import printable
from cartgrasp.frames import Array
from cartgrasp.logs import RunLog

from ..suspicion import Suspicion

MISSED = 1.5
"""Usual steps, from which a row is missing in between; clocks jitter by less."""
SLOW = 0.2
"""s between rows: carts are started and stopped within half a second, and three samples at least show that."""
FEWEST = 4


@dataclass(frozen=True)
class Gaps:
    """The usual step and the longest (s), when that begins, and how many rows would fill all gaps."""

    step: float
    longest: float
    start: float
    missing: int

    @classmethod
    def of(cls, time: Array) -> Gaps | None:
        """Of times (n,); None where there are too few."""
        if len(time) < FEWEST:
            return None
        steps = np.diff(time)
        usual, at = float(np.median(steps)), int(steps.argmax())
        wide = steps > MISSED * usual
        missing = int(np.round(steps[wide] / usual - 1).sum())
        return cls(usual, float(steps[at]), float(time[at]), missing)


def holes(log: RunLog) -> tuple[Suspicion, ...]:
    """Of all rows, then of sensors that miss more than those."""
    rows = Gaps.of(log.time)
    if rows is None:
        return ()
    sensors = [("pose", log.pose)]
    if log.velocity is not None:
        sensors.append(("velocity", log.velocity))
    sensors += [(name, arm.wrench) for name, arm in log.arms.items()]
    told = [_told("time", rows, "rows")]
    for where, columns in sensors:
        own = Gaps.of(log.time[np.isfinite(columns).all(axis=1)])
        if own is not None and (own.longest > rows.longest or own.step > MISSED * rows.step):
            told.append(_told(where, own, f"samples of {printable(where)}"))
    return tuple(one for one in told if one is not None)


def _told(where: str, gaps: Gaps, what: str) -> Suspicion | None:
    if gaps.missing:
        words = (
            f"{gaps.missing} {what} are missing: they come every {gaps.step:.3g} s, and once not for "
            f"{gaps.longest:.3g} s (from t = {gaps.start:.2f} s); record without losses, a gap hides what happens"
        )
        return Suspicion("holes", where, 0.99, gaps.longest, words)
    if gaps.step > SLOW:
        words = (
            f"no {what} are missing, there are no holes: they come evenly, but slowly, every {gaps.step:.3g} s "
            f"({1 / gaps.step:.3g} Hz); record at {1 / SLOW:.0f} Hz or more, starts and stops fall between them"
        )
        return Suspicion("holes", where, 0.99, gaps.step, words)
    return None
