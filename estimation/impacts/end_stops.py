"""End stops, from impacts: three or more that turn the cart round at one place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.effects import EndStop

from .impacts import Impact

MIN_STOP_IMPACTS = 3
STOP_POSITION_TOLERANCE = 0.1
"""m: what a bumper gives, and how far off a tracker may be."""
MIN_HEADING_COSINE = 0.5
"""Cosine of the heading: a cart that goes more across than along x is stopped by something else than a place on x."""


@dataclass(frozen=True)
class StopEstimate:
    """A stop at `position` (m, along x of {s}) for a cart at smaller x (`side` 1) or larger x (-1), as so many impacts
    tell it; `restitution` is the share of the speed that comes back."""

    position: float
    position_std: float
    restitution: float
    restitution_std: float
    side: float
    count: int

    def is_at(self, known: EndStop) -> bool:
        """Whether it is a stop that a cart has already."""
        return self.side == known.side and abs(self.position - known.position) < STOP_POSITION_TOLERANCE

    def effect(self, label: str = "") -> EndStop:
        """For a cart, to bounce off."""
        return EndStop(self.position, self.side, min(max(self.restitution, 0.0), 1.0), label=label)


def end_stops(impacts: Sequence[Impact]) -> tuple[StopEstimate, ...]:
    """Those that were hit `MIN_STOP_IMPACTS` times or more, by their place."""
    found = []
    for side in (1.0, -1.0):
        left = [impact for impact in impacts if _turns(impact, side)]
        while len(together := _most_together(left)) >= MIN_STOP_IMPACTS:
            found.append(_estimate(together, side))
            left = [impact for impact in left if impact not in together]
    return tuple(sorted(found, key=lambda one: one.position))


def _turns(impact: Impact, side: float) -> bool:
    """Whether the cart came from a side along x, and went back."""
    along = side * math.cos(impact.pose[2])
    return abs(along) >= MIN_HEADING_COSINE and impact.speed_before * along > 0.0 >= impact.speed_after * along


def _most_together(impacts: Sequence[Impact]) -> list[Impact]:
    """The most that are within `STOP_POSITION_TOLERANCE`."""
    groups = [
        [one for one in impacts if 0.0 <= one.pose[0] - first.pose[0] <= STOP_POSITION_TOLERANCE] for first in impacts
    ]
    return max(groups, key=len, default=[])


def _estimate(impacts: Sequence[Impact], side: float) -> StopEstimate:
    """The mean place; and least squares of speeds after on speeds before, whose errors are alike."""
    places = np.array([impact.pose[0] for impact in impacts])
    before, after = np.abs([[i.speed_before, i.speed_after] for i in impacts]).T
    share = float(before @ after / (before @ before))
    left = after - share * before
    n = len(impacts)
    return StopEstimate(
        position=float(places.mean()),
        position_std=float(places.std(ddof=1) / math.sqrt(n)),
        restitution=share,
        restitution_std=float(math.sqrt(left @ left / (n - 1) / (before @ before))),
        side=side,
        count=n,
    )
