"""Under what a cart was at some times: how it moved, where, and what each arm gave it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..batch.wrench_regression import WrenchRegression
from .generic import Course
from .pushes import arm_wrenches

SMOOTHED = 0.25
"""s, on each side."""


@dataclass(frozen=True)
class Circumstances:
    """At some times (b,) of logs (b,), which have names: the course; of each arm the planar wrench (b, 3) in {b} and
    the contact's place there (b, 2)."""

    log: np.ndarray
    names: tuple[str, ...]
    course: Course
    wrenches: Mapping[str, Array]
    contacts: Mapping[str, Array]

    @classmethod
    def of(
        cls, time: Array, log: np.ndarray, regressions: Sequence[WrenchRegression], cart: CartModel
    ) -> Circumstances:
        arms = tuple(dict.fromkeys(arm for regression in regressions for arm in regression.log.arms))
        wrenches = {arm: np.zeros((len(time), 3)) for arm in arms}
        contacts = {arm: np.full((len(time), 2), np.nan) for arm in arms}
        for k, regression in enumerate(regressions):
            own = log == k
            rows = np.clip(np.searchsorted(regression.motion.time, time[own]), 0, len(regression.motion.time) - 1)
            for arm, wrench in arm_wrenches(regression, cart, SMOOTHED).items():
                wrenches[arm][own] = wrench[rows]
                contacts[arm][own] = regression.rows.arms[arm].contact[rows, :2]
        motions = [regression.motion for regression in regressions]
        names = tuple(regression.name for regression in regressions)
        return cls(log, names, Course.of(time, log, motions), wrenches, contacts)

    @property
    def total(self) -> Array:
        """Of all arms (b, 3), in {b}."""
        return np.asarray(sum(self.wrenches.values()))

    @property
    def way(self) -> Array:
        """Travelled since the log's begin (b,), m, be it forward or backward."""
        return self.course.rolled[:, -1]

    @property
    def elapsed(self) -> Array:
        """Since the begin of each log (b,), s."""
        begin = [float(self.course.time[self.log == k].min(initial=np.inf)) for k in range(len(self.names))]
        return np.asarray(self.course.time - np.array(begin)[self.log])

    def strength(self, arm: str) -> Array:
        """Of an arm's force in the plane (b,), N."""
        return np.asarray(np.hypot(*self.wrenches[arm][:, :2].T))
