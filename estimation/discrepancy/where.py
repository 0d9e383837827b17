"""Where and when simulation and measurement disagree, in sentences that a person can act on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from cartgrasp.frames import Array

from .fitted import SCATTER_BLOCK, Scatter
from .generic import Course

LEAST_SHARE, LEAST_LIFT = 0.25, 1.4
"""Of the disagreement, and how much more of it than of the time, for a condition worth telling."""
MOST = 8
SLOW, TURNING, FAST_SHARE = 0.12, 0.08, 0.75
AFTER_REVERSAL = 0.4
"""m."""
DIRECTIONS = {
    1: ("forward_force",),
    2: ("forward_force", "yaw_moment"),
    3: ("forward_force", "side_force", "yaw_moment"),
}


@dataclass(frozen=True)
class Disagreement:
    """A part of a log, what it has in common, and how large the residual is there (N or N·m, root mean square) and its
    share of the whole disagreement."""

    start: float
    stop: float
    coordinate: str
    condition: str
    size: float
    share: float

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


def where(scatter: Scatter, course: Course) -> list[Disagreement]:
    """The conditions that gather the disagreement, the largest share first."""
    f = scatter.mean.shape[1]
    found = []
    for i in range(f):
        chi = scatter.mean[:, i] ** 2 * scatter.information[:, i, i] / scatter.excess
        beyond = np.maximum(chi - 1.0, 0.0)
        total = float(beyond.sum())
        if total <= 3 * np.sqrt(2 * len(chi)):
            continue
        for condition, chosen in _conditions(course):
            share, time_share = float(beyond[chosen].sum()) / total, float(chosen.mean())
            if 0 < time_share < 1 and share >= LEAST_SHARE and share >= LEAST_LIFT * time_share:
                times = scatter.start[chosen]
                size = float(np.sqrt((scatter.mean[chosen, i] ** 2).mean()))
                stop = float(times.max()) + SCATTER_BLOCK
                text = f"{100 * share:.0f} % of the misfit lies {condition} ({100 * time_share:.0f} % of the time)"
                found.append(Disagreement(float(times.min()), stop, DIRECTIONS[f][i], text, size, share))
    return sorted(found, key=lambda one: -one.share)[:MOST]


def _conditions(course: Course) -> Iterator[tuple[str, np.ndarray]]:
    speed = course.speed
    moving = np.abs(speed) > 0.02
    yield f"within {AFTER_REVERSAL} m after a reversal", moving & (course.since_reversal < AFTER_REVERSAL)
    yield "while it rolls forward", speed > 0.02
    yield "while it rolls backward", speed < -0.02
    yield f"below {SLOW} m/s", moving & (np.abs(speed) < SLOW)
    fast = FAST_SHARE * float(np.abs(speed).max())
    yield f"above {fast:.2f} m/s", np.abs(speed) > fast
    yield "while it turns left", course.turning > TURNING
    yield "while it turns right", course.turning < -TURNING
    yield "while it goes straight", moving & (np.abs(course.turning) <= TURNING)
    yield from _in_time(course.time)
    yield from _in_place(course.place)
    quarter = np.round(course.heading / (np.pi / 2)) % 4
    for k, name in enumerate(("+x", "+y", "-x", "-y")):
        yield f"while it heads along the floor's {name}", quarter == k


def _in_time(time: Array) -> Iterator[tuple[str, np.ndarray]]:
    for length in (2.0, 10.0):
        for start in np.arange(time.min(), time.max(), length):
            yield f"from t = {start:.0f} s to {start + length:.0f} s", (time >= start) & (time < start + length)
    middle = (time.min() + time.max()) / 2
    yield f"after t = {middle:.0f} s", time >= middle


def _in_place(place: Array) -> Iterator[tuple[str, np.ndarray]]:
    low, high = np.floor(place.min(axis=0)), np.ceil(place.max(axis=0))
    for x in np.arange(low[0], high[0]):
        for y in np.arange(low[1], high[1]):
            inside = np.asarray((place >= (x, y)).all(axis=1) & (place < (x + 1, y + 1)).all(axis=1))
            if inside.any():
                yield f"where x is {x:.0f} to {x + 1:.0f} m and y {y:.0f} to {y + 1:.0f} m", inside
