"""Wrenches that come again, to the last bit, for longer than by chance: a sensor, or its driver, that has frozen.

What its noise changes at nearly every row does not stay as it is. Of n rows, of which a share s repeats the one before,
a run of k repeats comes by chance n sᵏ times. Sensors that tell no noise may tell the same for as long as they like,
and a hand that holds nothing gives nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from cartgrasp.errors import printable
from cartgrasp.frames import Array
from cartgrasp.logs import ArmLog

from .suspicion import Suspicion

MAX_CHANCE_RUNS = 1e-3
"""How many such runs a log has by chance."""
MAX_FROZEN_FRACTION = 0.5
"""Share of the rows: what repeats more often is a sensor that is slower than the rows."""


class Frozen(NamedTuple):
    """Rows (n,) that are no measurements, and the longest run of them: where it begins and how many rows it has."""

    rows: np.ndarray
    first: int
    longest: int


def frozen_wrench(wrench: Array) -> Frozen | None:
    """What is frozen of a wrench (n, 6), NaN where missing."""
    there = np.flatnonzero(np.isfinite(wrench).all(axis=1))
    known = wrench[there]
    again = np.r_[False, ((known[1:] == known[:-1]).all(axis=1) & known[1:].any(axis=1))] if len(known) else np.zeros(0)
    edges = np.flatnonzero(np.diff(np.r_[False, again, False].astype(int))).reshape(-1, 2)
    if not len(edges):
        return None
    runs = edges[:, 1] - edges[:, 0]
    least = next((k for k in np.unique(runs) if _by_chance(runs, int(k), len(known)) < MAX_CHANCE_RUNS), None)
    if least is None:
        return None
    rows, taken = np.zeros(len(wrench), dtype=bool), np.zeros(len(known), dtype=bool)
    for first, last in edges[runs >= least]:
        taken[first:last] = True
    if taken.mean() > MAX_FROZEN_FRACTION or not tells_noise(known[~taken]):
        return None
    rows[there[taken]] = True
    longest = int(np.argmax(runs))
    return Frozen(rows, int(there[edges[longest, 0]]), int(runs[longest]))


def without_frozen(arm: ArmLog) -> ArmLog:
    """The arm, with such rows as missing samples."""
    found = frozen_wrench(arm.wrench)
    return arm if found is None else ArmLog(arm.contact, np.where(found.rows[:, None], np.nan, arm.wrench))


def frozen_arm(name: str, arm: ArmLog, time: Array) -> Iterator[Suspicion]:
    """`repeated` of an arm."""
    found = frozen_wrench(arm.wrench)
    if found is None:
        return
    count, k = int(found.rows.sum()), found.longest
    words = (
        f"{printable(name)}: {count} of {len(time)} rows repeat the wrench before to the last bit, {k} in a row from "
        f"t = {time[found.first]:g} s on, though its noise changes it at nearly every other: a sensor that froze; "
        "these rows are left out: leave such cells blank"
    )
    yield Suspicion("repeated", name, 0.99, len(time) / max(len(time) - count, 1), words, put_right=True)


def tells_noise(known: Array) -> bool:
    """Whether a component of samples (n, k) goes to and fro from row to row, as white noise does: that changes by
    √3 times as much over two steps as over one, and what is smooth by less."""
    if len(known) < 3:
        return False
    once, twice = np.abs(np.diff(known, axis=0)), np.abs(np.diff(known, 2, axis=0))
    return bool((np.median(twice, axis=0) > np.median(once, axis=0)).any())


def _by_chance(runs: np.ndarray, k: int, n: int) -> float:
    """How many runs of k repeats there are by chance in n rows, as often as shorter ones come."""
    shorter, longer = runs[runs < k], runs[runs >= k]
    share = (shorter.sum() + 1.0) / (n - longer.sum() + 2.0)
    return float(n * share**k)
