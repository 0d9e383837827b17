"""Wrenches that say nothing of what acted: a sensor, or its driver, that has frozen, or one at the end of its range.

A frozen one repeats itself, to the last bit, for longer than by chance. What its noise changes at nearly every row does
not stay as it is. Of n rows, of which a share s repeats the one before, a run of k repeats comes by chance n sᵏ times.
Sensors that tell no noise may tell the same for as long as they like, and a hand that holds nothing gives nothing. A
coarse one that rests comes back to the same number again and again, and what freezes, to none.

Noise keeps a sensor from telling one number twice. One that is the largest of all, and comes far more often than any
other, is the end of its range. Rows of it are left out: taken as they are, they make the cart too light.
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
WRENCH_COMPONENTS = ("fx", "fy", "fz", "tx", "ty", "tz")
MIN_CLIPPED_ROWS, MIN_CLIPPED_COUNT_RATIO = 10, 5.0
"""Rows at an end; times as many as of any other number."""
CLIP_MARGIN_INTERVAL = 0.03
"""s: of what is near an end, noise lets only the smaller part through. Of 0.03 to 0.1 masses say the same."""


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
    edges = edges[runs >= least]
    _, which, times = np.unique(known[edges[:, 0]], axis=0, return_inverse=True, return_counts=True)
    edges = edges[times[which.reshape(-1)] == 1]
    for first, last in edges:
        taken[first:last] = True
    if not 0.0 < taken.mean() <= MAX_FROZEN_FRACTION or not tells_noise(known[~taken]):
        return None
    rows[there[taken]] = True
    first, last = max(edges, key=lambda edge: int(edge[1] - edge[0]))
    return Frozen(rows, int(there[first]), int(last - first))


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


class RangeLimit(NamedTuple):
    """A component's index, the number (N or N·m) that it does not go beyond, and where (n,) it is told."""

    component: int
    value: float
    rows: np.ndarray


def range_limits(wrench: Array) -> Iterator[RangeLimit]:
    """The ends of range that a wrench (n, 6), NaN where missing, was told at. Nothing is no end."""
    for i, column in enumerate(wrench.T):
        known = column[np.isfinite(column)]
        both = (known.max(), known.min()) if len(known) else ()
        within = known[~np.isin(known, both)]
        for value in both if tells_noise(within[:, None]) else ():
            count = int((known == value).sum())
            if (
                value != 0.0
                and count >= MIN_CLIPPED_ROWS
                and count > MIN_CLIPPED_COUNT_RATIO * np.unique(within, return_counts=True)[1].max()
            ):
                yield RangeLimit(i, float(value), column == value)


def without_clipped(arm: ArmLog, time: Array) -> ArmLog:
    """The arm, with such rows, and those `CLIP_MARGIN_INTERVAL` about them, as missing samples at times (n,)."""
    found = [end.rows for end in range_limits(arm.wrench)]
    at = time[np.any(found, axis=0)] if found else time[:0]
    if not len(at):
        return arm
    after = np.searchsorted(at, time)
    before, behind = time - at[np.maximum(after - 1, 0)], at[np.minimum(after, len(at) - 1)] - time
    near = (np.abs(before) < CLIP_MARGIN_INTERVAL) | (np.abs(behind) < CLIP_MARGIN_INTERVAL)
    return ArmLog(arm.contact, np.where(near[:, None], np.nan, arm.wrench))


def clipped_arm(name: str, arm: ArmLog, time: Array) -> Iterator[Suspicion]:
    """`scale` of an arm, by component and end."""
    for end in range_limits(arm.wrench):
        unit, count = "N" if end.component < 3 else "N·m", int(end.rows.sum())
        words = (
            f"{printable(name)}: {WRENCH_COMPONENTS[end.component]} is {end.value:.6g} {unit} in {count} of "
            f"{len(time)} rows, first at t = {time[int(np.argmax(end.rows))]:g} s, and never beyond: the end of "
            "the sensor's range; these rows are left out: push less, or take a sensor for more"
        )
        yield Suspicion("scale", name, 0.99, None, words, put_right=True)
