"""Under what a cart was at some times: how it moved, where, and what each arm gave it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..weak_form.balances import Balances
from .course import Course, rows_at

SMOOTHED = 0.25
"""s, on each side, over which wrenches are averaged."""


@dataclass(frozen=True)
class Circumstances:
    """At some times (b,) of logs (b,), which have names: the course; of each arm the planar wrench (b, 3) in {b} and
    the contact's place there (b, 2). Logs may have no arms."""

    time: Array
    log: np.ndarray
    names: tuple[str, ...]
    course: Course
    wrenches: Mapping[str, Array]
    contacts: Mapping[str, Array]

    @classmethod
    def of(cls, time: Array, log: np.ndarray, logs: Sequence[Balances], cart: CartModel) -> Circumstances:
        """At times (b,) by the clock of the logs (b,) to which they belong; those of one log come after those of the
        one before."""
        arms = tuple(dict.fromkeys(arm for balances in logs for arm in balances.wrenches.arms))
        wrenches = {arm: np.zeros((len(time), 3)) for arm in arms}
        contacts = {arm: np.full((len(time), 2), np.nan) for arm in arms}
        for k, balances in enumerate(logs):
            own = log == k
            rows = rows_at(balances.motion, time[own])
            for arm, wrench in arm_wrenches(balances, cart, SMOOTHED).items():
                wrenches[arm][own] = wrench[rows]
                contacts[arm][own] = _held(balances, arm, time[own])
        course = Course.of(time, log, [balances.motion for balances in logs])
        firsts = _firsts(logs)
        names = tuple(logs[k].name for k in dict.fromkeys(firsts))
        return cls(time, np.unique(firsts, return_inverse=True)[1][log], names, course, wrenches, contacts)

    @property
    def total(self) -> Array:
        """Of all arms (b, 3), in {b}."""
        return np.asarray(sum(self.wrenches.values(), np.zeros((len(self.time), 3))))

    def strength(self, arm: str) -> Array:
        """Of an arm's force in the plane (b,), N."""
        return np.asarray(np.hypot(*self.wrenches[arm][:, :2].T))


def _firsts(logs: Sequence[Balances]) -> list[int]:
    """Of each part, where the log begins that it is cut from: one of the same name that goes on later."""
    found: list[int] = []
    for k, balances in enumerate(logs):
        before = logs[k - 1]
        goes_on = k > 0 and before.name == balances.name and balances.motion.time[0] > before.motion.time[-1]
        found.append(found[-1] if goes_on else k)
    return found


def arm_wrenches(balances: Balances, cart: CartModel, smoothed: float) -> dict[str, Array]:
    """Of each arm, corrected by what a cart's sensors do and averaged over `smoothed` (s) on each side of the motion's
    times, the planar wrench (n, 3) in {b}."""
    record = balances.wrenches
    reach = max(1, round(smoothed / balances.motion.step))
    found = {}
    for arm, grasp, recorded in zip(record.arms, record.grasps, record.recorded, strict=True):
        planar = (grasp @ cart.corrected_wrench(arm, recorded)[0][..., None])[..., 0]
        found[arm] = _means(planar, reach)
    return found


def _means(values: Array, reach: int) -> Array:
    """Of values (n, k), over so many rows on each side; at the ends, of those that are there."""
    n = len(values)
    total = np.vstack([np.zeros(values.shape[1]), np.cumsum(values, axis=0)])
    first, last = np.maximum(np.arange(n) - reach, 0), np.minimum(np.arange(n) + reach + 1, n)
    return np.asarray((total[last] - total[first]) / (last - first)[:, None])


def _held(balances: Balances, arm: str, time: Array) -> Array:
    """The arm's contact point (b, 2) that was recorded last; unknown before there was one."""
    log = balances.log
    contact = log.arms[arm].contact[:, :2]
    known = np.flatnonzero(np.isfinite(contact).all(axis=1))
    last = np.searchsorted(log.time[known], time, side="right") - 1
    if not len(known):
        return np.full((len(time), 2), np.nan)
    return np.where(last[:, None] >= 0, contact[known[np.maximum(last, 0)]], np.nan)
