"""The values of a schedule: what a regrasp costs, what is held, from when to when, and what was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from cartgrasp.errors import UsageError
from cartgrasp.frames import Array


@dataclass(frozen=True)
class RegraspCost:
    """For `duration` (s, rounded up to whole stages) the arm gives no wrench; `effort` (N²·s) is added once."""

    duration: float = 0.5
    effort: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite([self.duration, self.effort]).all() and min(self.duration, self.effort) >= 0):
            raise UsageError(f"regrasp: {self} must have a finite duration and effort >= 0")


@dataclass(frozen=True, eq=False)
class Grip:
    """The contact (3,) in {b} that an arm holds, or from the time `ready` (s) on will hold."""

    contact: Array
    ready: float = -np.inf


@dataclass(frozen=True)
class Horizon:
    """From `now` (s) for `length` (s), but at most to the reference's end, in stages of at most `stage` (s). `held` are
    the grips that one starts from, by arm; without it the first grips are chosen, free of charge."""

    now: float = 0.0
    stage: float = 0.25
    held: Mapping[str, Grip] | None = None
    min_hand_distance: float = 0.0
    length: float = np.inf


@dataclass(frozen=True, eq=False)
class Regrasp:
    """An arm leaves `origin` (3,) at `start` and holds `target` (3,) from `stop` on, s."""

    arm: str
    start: float
    stop: float
    origin: Array
    target: Array


@dataclass(frozen=True)
class BlockedStage:
    """A stage that can't be done, and why."""

    start: float
    stop: float
    words: str


@dataclass(frozen=True, eq=False)
class Schedule:
    """K stages between `times` (K + 1,), with the effort (N²) of each; by arm, contacts (K, 3) in {b} held or gone to,
    and whether the arm `holds` (K,). No schedule costs less than `bound` (N²·s); `solved` counts QPs. When
    `infeasible`, `blocked` names the stages and there are no contacts."""

    status: str
    times: Array
    contacts: Mapping[str, Array] = field(default_factory=dict)
    holds: Mapping[str, Array] = field(default_factory=dict)
    efforts: Array = field(default_factory=lambda: np.zeros(0))
    regrasps: tuple[Regrasp, ...] = ()
    total: float = np.inf
    bound: float = np.inf
    solved: int = 0
    blocked: tuple[BlockedStage, ...] = ()

    def grips(self, time: float) -> dict[str, Grip]:
        """What each arm holds or goes to at a time: where to start the next schedule from."""
        k = int(np.clip(np.searchsorted(self.times, time + 1e-9, side="right") - 1, 0, len(self.times) - 2))
        ready = {r.arm: r.stop for r in self.regrasps if r.start <= time + 1e-9 < r.stop}
        return {arm: Grip(points[k], ready.get(arm, -np.inf)) for arm, points in self.contacts.items()}
