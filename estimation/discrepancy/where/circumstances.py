"""Circumstances of a cart at some times: how it moved, where, and what each arm gave it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import compress, pairwise

import numpy as np
from scipy.ndimage import uniform_filter1d

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ...weak_form.balances import Balances
from ..search.covariates import Covariates, rows_at

WRENCH_AVERAGING_INTERVAL = 0.25
"""Time (s) on each side over which wrenches are averaged."""


@dataclass(frozen=True)
class Circumstances:
    """The course at times (b,) of named logs (b,), and each arm's planar wrench (b, 3) in {b} and contact point there
    (b, 2). Logs may have no arms."""

    time: Array
    log: np.ndarray
    names: tuple[str, ...]
    covariates: Covariates
    wrenches: Mapping[str, Array]
    contacts: Mapping[str, Array]

    @classmethod
    def of(cls, time: Array, log: np.ndarray, logs: Sequence[Balances], cart: CartModel) -> Circumstances:
        """Circumstances at times (b,) by the clock of the logs (b,) to which they belong. Those of one log come after
        those of the one before."""
        arms = tuple(dict.fromkeys(arm for balances in logs for arm in balances.wrenches.arms))
        wrenches = {arm: np.zeros((len(time), 3)) for arm in arms}
        contacts = {arm: np.full((len(time), 2), np.nan) for arm in arms}
        for k, balances in enumerate(logs):
            own = log == k
            rows = rows_at(balances.motion, time[own])
            for arm, wrench in arm_wrenches(balances, cart, WRENCH_AVERAGING_INTERVAL).items():
                wrenches[arm][own] = wrench[rows]
                contacts[arm][own] = _held(balances, arm, time[own])
        course = Covariates.of(time, log, [balances.motion for balances in logs])
        begins = [True, *(not _goes_on(*both) for both in pairwise(logs))]
        names = tuple(balances.name for balances in compress(logs, begins))
        return cls(time, np.cumsum(begins)[log] - 1, names, course, wrenches, contacts)

    @property
    def total(self) -> Array:
        """Planar wrench (b, 3) of all arms together, in {b}."""
        return np.asarray(sum(self.wrenches.values(), np.zeros((len(self.time), 3))))

    def strength(self, arm: str) -> Array:
        """Size of an arm's force in the plane (b,), N."""
        return np.asarray(np.hypot(*self.wrenches[arm][:, :2].T))


def _goes_on(before: Balances, balances: Balances) -> bool:
    """Whether both are parts of one log: of the same name, one after the other."""
    return before.name == balances.name and bool(balances.motion.time[0] > before.motion.time[-1])


def arm_wrenches(balances: Balances, cart: CartModel, smoothed: float) -> dict[str, Array]:
    """Planar wrench (n, 3) of each arm in {b}. It is corrected by what a cart's sensors do, and averaged over
    `smoothed` (s) on each side of the motion's times."""
    record = balances.wrenches
    reach = max(1, round(smoothed / balances.motion.step))
    found = {}
    for i, (arm, grasp, recorded) in enumerate(zip(record.arms, record.grasps, record.recorded, strict=True)):
        planar = (grasp @ record.corrected(cart, i, recorded)[0][..., None])[..., 0]
        found[arm] = _means(planar, reach)
    return found


def _means(values: Array, reach: int) -> Array:
    """Means of values (n, k) over so many rows on each side; at the ends, over those that are there."""
    there = np.ones((len(values), 1))
    sums, count = (uniform_filter1d(each, 2 * reach + 1, axis=0, mode="constant") for each in (values, there))
    return np.asarray(sums / count)


def _held(balances: Balances, arm: str, time: Array) -> Array:
    """The arm's contact point (b, 2) that was recorded last; unknown before there was one."""
    log = balances.log
    contact = log.arms[arm].contact[:, :2]
    known = np.flatnonzero(np.isfinite(contact).all(axis=1))
    held = np.vstack([np.full((1, 2), np.nan), contact[known]])
    return np.asarray(held[np.searchsorted(log.time[known], time, side="right")])
