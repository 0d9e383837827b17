"""Rows that a recorder wrote again where nothing new had come, and rows that it put in between by straight lines.

Neither is a measurement. A row written again makes the cart stand still and then jump; one in between hides the noise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.errors import printable
from cartgrasp.frames import Array
from cartgrasp.logs import RunLog
from cartgrasp.logs.run_log import ArmLog

from ..evidence import from_odds
from ..prior import ODDS
from ..suspicion import TOLD, Suspicion
from .steps import step_of

LONGEST = 0.25
"""s: what repeats for longer rests."""
TINY = 1e-12
"""Of a column's largest value: less is round-off."""
RESOLVED = 1.5
"""Steps of the sensor: more, after a repetition, than its resolution makes."""
ROUNDED = 10.0
"""How much rarer a value is that comes back after another one than one that stays: 1 in white noise on a grid, 5 in the
smooth forces of a measured push."""
STRAIGHT = 1e-3
"""Of the usual bend: a bend of white noise is as small in a thousandth of the rows."""


@dataclass(frozen=True)
class Repeats:
    """Which rows (n,) repeat the last one, how many there are in all, and how many equal the last but one and not the
    last: as many repeat by chance."""

    row: np.ndarray
    there: int
    by_chance: int

    @property
    def count(self) -> int:
        return int(self.row.sum())

    @property
    def log_evidence(self) -> float:
        """Of the count: an exponential prior with a tenth of the rows as its mean, against a Poisson count of `ROUNDED`
        times the chance ones."""
        chance = ROUNDED * (self.by_chance + 0.5)
        if self.count <= chance:
            return 0.0
        return -math.log(0.1 * self.there) + chance - self.count * math.log(chance) + math.lgamma(self.count + 1)

    @property
    def probability(self) -> float:
        return from_odds(self.log_evidence + math.log(ODDS["repeated"]))


def repeats(rows: Array, time: Array) -> Repeats:
    """Of rows (n, k) at times (n,), NaN where missing: those that equal the one before, for a short while, until
    something comes that differs by more than the sensor's resolution."""
    found = np.zeros(len(rows), dtype=bool)
    there = np.flatnonzero(np.isfinite(rows).all(axis=1))
    if len(there) < 3:
        return Repeats(found, len(there), 0)
    seen, t = rows[there], time[there]
    tiny = TINY * np.maximum(np.abs(seen).max(axis=0), 1e-300)
    changes = np.abs(np.diff(seen, axis=0))
    moved = np.any(changes > tiny, axis=1)
    far = np.any(changes > RESOLVED * _resolution(seen, changes, tiny), axis=1)
    starts = np.flatnonzero(np.r_[True, moved])
    ends = np.r_[starts[1:], len(seen)] - 1
    inner = ends < len(seen) - 1
    is_short = np.zeros(len(starts), dtype=bool)
    is_short[inner] = (t[ends[inner] + 1] - t[starts[inner]] < LONGEST) & far[ends[inner]]
    run = np.cumsum(np.r_[True, moved]) - 1
    found[there[np.r_[False, ~moved] & is_short[run]]] = True
    back = (np.abs(seen[2:] - seen[:-2]) <= tiny).all(axis=1) & far[1:]
    return Repeats(found, len(there), int(back.sum()))


def _resolution(seen: Array, changes: Array, tiny: Array) -> Array:
    """Of each column (k,): its grid's step, or the smallest change."""
    smallest = np.min(np.where(changes > tiny, changes, np.inf), axis=0)
    steps = [step_of(column) for column in seen.T]
    return np.array([s if step is None else step for s, step in zip(smallest, steps, strict=True)])


def straight_rows(rows: Array, time: Array) -> np.ndarray:
    """Which rows (n,) of (n, k) lie on the straight line between knots that are no neighbours of one another. What
    moves evenly for long is no such row: knots come one by one, and at least one for every ten rows."""
    there = np.flatnonzero(np.isfinite(rows).all(axis=1))
    found = np.zeros(len(rows), dtype=bool)
    if len(there) < 20:
        return found
    seen, t = rows[there], time[there]
    slope = np.diff(seen, axis=0) / np.diff(t)[:, None]
    bend = np.abs(np.diff(slope, axis=0))
    usual = np.sqrt((bend**2).mean(axis=0))
    live = usual > 0
    if not live.any():
        return found
    is_bent = (bend[:, live] > STRAIGHT * usual[live]).any(axis=1)
    moves = (np.abs(slope[1:]) > 0).any(axis=1) & (np.abs(slope[:-1]) > 0).any(axis=1)
    alone = is_bent[1:-1] & ~is_bent[:-2] & ~is_bent[2:]
    straight = ~is_bent & moves
    is_knotted = 2 * alone.sum() > is_bent[1:-1].sum() and 10 * is_bent.sum() > straight.sum()
    if is_knotted and 3 * straight.sum() > len(there):
        found[there[1:-1][straight]] = True
    return found


def repeated(log: RunLog) -> tuple[Suspicion, ...]:
    """Of poses, velocities and each arm's wrenches."""
    sensors = [("pose", log.pose)]
    if log.velocity is not None:
        sensors.append(("velocity", log.velocity))
    sensors += [(name, arm.wrench) for name, arm in log.arms.items()]
    found = [_again(where, repeats(rows, log.time), log.time) for where, rows in sensors]
    found += [_between(where, straight_rows(rows, log.time), rows) for where, rows in sensors]
    return tuple(one for one in found if one is not None and one.probability >= TOLD)


def _again(where: str, found: Repeats, time: Array) -> Suspicion | None:
    if not found.count:
        return None
    fresh = found.there - found.count
    words = (
        f"{printable(where)}: {found.count} of {found.there} rows repeat the one before while the cart moves, as "
        f"a recorder writes where nothing new has come ({fresh / max(time[-1] - time[0], 1e-9):.3g} fresh a second); "
        "leave such cells blank, or record at the sensor's own rate"
    )
    return Suspicion("repeated", where, found.probability, found.there / fresh, words)


def _between(where: str, straight: np.ndarray, rows: Array) -> Suspicion | None:
    count, there = int(straight.sum()), int(np.isfinite(rows).all(axis=1).sum())
    if not count:
        return None
    words = (
        f"{printable(where)}: {count} of {there} rows lie on straight lines between others, so they were interpolated, "
        f"not measured, and hide the noise; leave them blank, one row in {there / (there - count):.2g} is a measurement"
    )
    return Suspicion("repeated", where, 0.99, there / (there - count), words)


def without_repeats(log: RunLog) -> RunLog:
    """The log, with what was written again or put in between as missing, where that is likely."""
    arms = {name: ArmLog(arm.contact, _fresh(arm.wrench, log.time)) for name, arm in log.arms.items()}
    velocity = None if log.velocity is None else _fresh(log.velocity, log.time)
    return replace(log, pose=_fresh(log.pose, log.time), velocity=velocity, arms=arms)


def _fresh(rows: Array, time: Array) -> Array:
    found = repeats(rows, time)
    stale = straight_rows(rows, time)
    if found.probability > 0.5:
        stale |= found.row
    return np.where(stale[:, None], np.nan, rows) if stale.any() else rows
