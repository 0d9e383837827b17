"""A hand that regrasps: it is unloaded along a ramp, moves, takes hold, and is loaded along a ramp.

A pure state machine in time. What the hand gives is its `share` of what it is planned to give: 1 while it holds,
exactly 0 while it moves and takes hold, linear in time between. It moves straight in {b}, at no more than its speed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.checks import number, positive
from cartgrasp.frames import Array

Point = tuple[float, float, float]
Distances = TypeVar("Distances", float, Array)
MAX_REGRASP_TIME, MAX_HAND_SPEED = 60.0, 10.0
"""s of a phase, m/s of a hand."""


class Phase(StrEnum):
    """In the order in which they pass."""

    HOLDS = "holds"
    UNLOADS = "unloads"
    MOVES = "moves"
    TAKES_HOLD = "takes hold"
    LOADS = "loads"


@dataclass(frozen=True)
class RegraspTimes:
    """What a regrasp takes.

    Args:
        speed: m/s of a hand that holds nothing, in {b}, at most.
        unload: s, from the whole wrench to none.
        take_hold: s, at the new contact, before it can give anything.
        load: s, from none to the whole wrench.

    Raises:
        UsageError: A time is negative, or the speed not above 0.

    Example:
        >>> from planning import RegraspTimes
        >>> round(RegraspTimes(speed=0.5, unload=0.2, take_hold=0.2, load=0.2).lasting(0.4), 3)
        1.4
    """

    speed: float = 0.5
    unload: float = 0.2
    take_hold: float = 0.2
    load: float = 0.2

    def __post_init__(self) -> None:
        positive("regrasp: speed", self.speed, MAX_HAND_SPEED, "give m/s")
        for name in ("unload", "take_hold", "load"):
            number(f"regrasp: {name}", getattr(self, name), 0.0, MAX_REGRASP_TIME, "give s")

    def away(self, distance: Distances) -> Distances:
        """s in which the hand gives nothing, for contacts so many m apart."""
        return distance / self.speed + self.take_hold

    def lasting(self, distance: Distances) -> Distances:
        """s from the whole wrench at one contact to the whole wrench at the other."""
        return self.unload + self.away(distance) + self.load


@dataclass(frozen=True)
class Hand:
    """Where a hand is, (x, y, z) in {b}, m; what it does; which `share` of its wrench it gives; where it goes; and for
    how long it has been taking hold, s."""

    point: Point
    phase: Phase = Phase.HOLDS
    share: float = 1.0
    target: Point | None = None
    taken: float = 0.0

    @property
    def is_away(self) -> bool:
        """Whether it gives nothing, for certain."""
        return self.phase in (Phase.MOVES, Phase.TAKES_HOLD)

    def sent(self, target: Point) -> Hand:
        """To another contact; one that is on its way, or there already, goes on as it does."""
        if self.phase is not Phase.HOLDS or target == self.point:
            return self
        return replace(self, phase=Phase.UNLOADS, target=target)

    def after(self, duration: float, times: RegraspTimes, may_leave: bool = True) -> Hand:
        """So many s later; a phase that ends in between leaves its rest unused, so that none is skipped. A hand that
        is unloaded stays until it `may_leave`: until what it still gives can be zero at once."""
        match self.phase:
            case Phase.UNLOADS:
                share = self.share - _part(duration, times.unload)
                if share > 1e-9:
                    return replace(self, share=share)
                return replace(self, share=0.0, phase=Phase.MOVES if may_leave else Phase.UNLOADS)
            case Phase.MOVES:
                return self._moved(times.speed * duration)
            case Phase.TAKES_HOLD:
                taken = self.taken + duration
                phase = Phase.TAKES_HOLD if taken < times.take_hold - 1e-9 else Phase.LOADS
                return replace(self, taken=taken, phase=phase)
            case Phase.LOADS:
                share = self.share + _part(duration, times.load)
                return replace(self, share=share) if share < 1 - 1e-9 else Hand(self.point)
        return self

    def _moved(self, length: float) -> Hand:
        assert self.target is not None
        left = math.dist(self.point, self.target)
        if left <= length * (1 + 1e-9):
            return replace(self, point=self.target, phase=Phase.TAKES_HOLD)
        x, y, z = (a + length / left * (b - a) for a, b in zip(self.point, self.target, strict=True))
        return replace(self, point=(x, y, z))


def point_of(contact: ArrayLike) -> Point:
    x, y, z = np.asarray(contact, dtype=float).tolist()
    return x, y, z


def _part(duration: float, whole: float) -> float:
    return duration / whole if whole > 0 else 1.0
