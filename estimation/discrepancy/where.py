"""Where and when simulation and measurement disagree, in sentences that a person can act on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from scipy.special import rel_entr

from cartgrasp.frames import Array

from .circumstances import Circumstances
from .course import ROLLING
from .residual import UNITS, Residual
from .residual_map import Profile, profiles

LEAST_SHARE, LEAST_LIFT = 0.25, 1.4
"""Of the disagreement, and how much more of it than of the time, for a condition worth telling."""
LEAST_ALONG = 0.5
"""Of the disagreement, for a variable that it goes with."""
MOST = 8
MOST_KNOWN, WIDER = 0.8, 1.25
"""Of a condition's disagreement, in another that was told and is no more than so many times as wide: it says nothing
new."""
SLOW, TURNING = 0.12, 0.08
"""m/s, rad/s."""
MOVES = "while it moves"
ALL_MOTION = 0.95
"""Of the stretches in which a cart moves: a condition that holds in so many says no more than that it moves."""
FAST_SHARE, STRONG_SHARE, WEAK_SHARE = 0.75, 0.7, 0.2
"""Of the fastest speed, and of the largest force or moment."""
LARGEST = 98.0
"""Percentile: what is larger is an accident."""
AFTER_REVERSAL = 0.4
"""m."""
MOST_CONTACTS = 6


def short(value: float) -> str:
    """Of two digits, without an exponent where there need be none: 230 and not 2.3e+02."""
    return f"{float(f'{value:.2g}'):g}"


Condition = tuple[str, np.ndarray]
"""In words, and the stretches (b,) that meet it."""


@dataclass(frozen=True)
class Disagreement:
    """A part of a log, what it has in common, and how large the residual is there (root mean square, in the
    coordinate's unit) and its share of the coordinate's whole disagreement."""

    start: float
    stop: float
    coordinate: str
    condition: str
    size: float
    share: float

    @property
    def sentence(self) -> str:
        """For people."""
        coordinate = self.coordinate.replace("_", " ").capitalize()
        return f"{coordinate}, {short(self.size)} {UNITS[self.coordinate]}: {self.condition}"

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


def where(residuals: Sequence[Residual]) -> list[Disagreement]:
    """The conditions that gather the disagreement, those first that tell the most: by how much more of it they hold
    than of the time. Then what else it goes along with."""
    there = [residual for residual in residuals if residual.disagrees]
    along = [told for residual in there for told in _along(residual)]
    found = sorted((told for residual in there for told in _of_one(residual)), key=lambda told: -told[0])
    return [*(one for _, one in found[: MOST - len(along)]), *along]


def _of_one(residual: Residual) -> list[tuple[float, Disagreement]]:
    """With what they tell (nats)."""
    total, told = float(residual.beyond.sum()), list[tuple[float, Condition, float, float]]()
    for words, chosen in _telling(residual):
        share = float(np.clip(residual.beyond[chosen].sum() / total, 0.0, 1.0))
        time_share = float(chosen.mean())
        if 0 < time_share < 1 and share >= LEAST_SHARE and share >= LEAST_LIFT * time_share:
            known = float(rel_entr(share, time_share) + rel_entr(1 - share, 1 - time_share))
            told.append((known, (words, chosen), share, time_share))
    kept = list[tuple[float, Disagreement]]()
    others = list[np.ndarray]()
    for known, (words, chosen), share, time_share in sorted(told, key=lambda one: -one[0]):
        if not any(_says(residual, other, chosen) for other in others):
            others.append(chosen)
            text = f"{100 * share:.0f} % of the misfit lies {words} ({100 * time_share:.0f} % of the time)"
            size = float(np.sqrt((residual.value[chosen] ** 2).mean()))
            kept.append((known, Disagreement(*_span(residual, chosen), residual.coordinate, text, size, share)))
    return kept


def _span(residual: Residual, chosen: np.ndarray) -> tuple[float, float]:
    """From when to when stretches lie, in the log that holds the most of their disagreement."""
    logs = np.where(chosen, residual.circumstances.log, -1)
    most = max(np.unique(logs[chosen]), key=lambda k: float(residual.beyond[logs == k].sum()))
    start = residual.start[logs == most]
    return float(start.min()), float(start.max()) + residual.duration


def _along(residual: Residual) -> list[Disagreement]:
    """What the residual goes along with the most, be it forward or backward, where that is most of it."""
    total, found = float(residual.beyond.sum()), list[tuple[float, Profile]]()
    for one in profiles(residual):
        standard = one.residual.mean / one.residual.std
        found.append((float(np.nansum(standard**2 - 1.0)) / total, one))
    share, best = max(found, key=lambda each: each[0], default=(0.0, None))
    if best is None or share < LEAST_ALONG:
        return []
    values, share = best.residual.mean, min(share, 1.0)
    ends = [f"{short(values[k])} {residual.unit} at {short(best.at[k])} {best.unit}" for k in _ends(values)]
    text = f"{100 * share:.0f} % of the misfit goes with the {best.variable}: {ends[0]}, {ends[1]}"
    span, size = _span(residual, np.ones(len(residual.start), dtype=bool)), float(np.sqrt((residual.value**2).mean()))
    return [Disagreement(*span, residual.coordinate, text, size, share)]


def _ends(values: Array) -> tuple[int, int]:
    """Where they are lowest and highest, the first of these first."""
    low, high = int(np.nanargmin(values)), int(np.nanargmax(values))
    return min(low, high), max(low, high)


def _says(residual: Residual, told: np.ndarray, chosen: np.ndarray) -> bool:
    """Whether one condition says what another does: what this holds lies there."""
    within = residual.beyond[told & chosen].sum() > MOST_KNOWN * residual.beyond[chosen].sum()
    return bool(within and told.sum() <= WIDER * chosen.sum())


def _telling(residual: Residual) -> Iterator[Condition]:
    """Without what holds whenever the cart moves, such as that it rolls forward, if it never does otherwise."""
    course = residual.circumstances.course
    moves = (np.abs(course.speed) > ROLLING) | (np.abs(course.yaw_rate) > TURNING)
    yield MOVES, moves
    for words, chosen in _conditions(residual):
        if (chosen & moves).sum() < ALL_MOTION * moves.sum() or not moves.any():
            yield words, chosen


def _conditions(residual: Residual) -> Iterator[Condition]:
    found = residual.circumstances
    yield from _in_motion(found)
    yield from _in_time(residual)
    yield from _in_place(found.course.place)
    quarter = np.round(found.course.heading / (np.pi / 2)) % 4
    for k, name in enumerate(("+x", "+y", "-x", "-y")):
        yield f"while it heads along the floor's {name}", quarter == k
    yield from _in_force(found)
    yield from _in_arms(found)


def _in_motion(found: Circumstances) -> Iterator[Condition]:
    speed, turning = found.course.speed, found.course.yaw_rate
    moving = np.abs(speed) > ROLLING
    yield f"within {AFTER_REVERSAL} m after a reversal", moving & (found.course.since_reversal < AFTER_REVERSAL)
    yield "while it rolls forward", speed > ROLLING
    yield "while it rolls backward", speed < -ROLLING
    yield f"below {SLOW} m/s", moving & (np.abs(speed) < SLOW)
    fast = FAST_SHARE * float(np.abs(speed).max())
    yield f"above {fast:.2f} m/s", np.abs(speed) > fast
    yield "while it turns left", turning > TURNING
    yield "while it turns right", turning < -TURNING
    yield "while it goes straight", moving & (np.abs(turning) <= TURNING)


def _in_time(residual: Residual) -> Iterator[Condition]:
    """Between change points of each log, and before and after each."""
    found, start = residual.circumstances, residual.start
    for k, name in enumerate(found.names):
        rows = np.flatnonzero(found.log == k)
        own = f" of {name}" if len(found.names) > 1 else ""
        if own:
            yield f"in {name}", found.log == k
        changes = residual.changes[k]
        for change in changes:
            at, way = start[rows[change]], found.course.travelled[rows[change]]
            yield f"after t = {at:.1f} s{own}, {way:.1f} m of its way", _among(rows[change:], start)
            yield f"before t = {at:.1f} s{own}, {way:.1f} m of its way", _among(rows[:change], start)
        for first, last in zip([0, *changes], [*changes, len(rows)], strict=True):
            ends = rows[first], rows[last - 1]
            begin, end = start[ends[0]], start[ends[1]] + residual.duration
            way = f"{found.course.travelled[ends[0]]:.1f} to {found.course.travelled[ends[1]]:.1f} m of its way"
            yield f"from t = {begin:.1f} s to {end:.1f} s{own}, {way}", _among(rows[first:last], start)


def _among(rows: np.ndarray, start: Array) -> np.ndarray:
    chosen = np.zeros(len(start), dtype=bool)
    chosen[rows] = True
    return chosen


def _in_place(place: Array) -> Iterator[Condition]:
    squares, number = np.unique(np.floor(place), axis=0, return_inverse=True)
    for k, (x, y) in enumerate(squares):
        yield f"where x is {x:.0f} to {x + 1:.0f} m and y {y:.0f} to {y + 1:.0f} m", number.ravel() == k


def _in_force(found: Circumstances) -> Iterator[Condition]:
    """That all arms give together."""
    if not found.wrenches:
        return
    force, moment = found.total[:, 0], found.total[:, 2]
    for values, unit, words in (
        (force, "N", ("the arms push it forward", "the arms pull it backward", "the arms push or pull")),
        (moment, "N·m", ("the arms turn it to the left", "the arms turn it to the right", "the arms turn it")),
    ):
        most = float(np.percentile(np.abs(values), LARGEST))
        strong, weak = STRONG_SHARE * most, WEAK_SHARE * most
        yield f"while {words[0]} with more than {short(strong)} {unit}", values > strong
        yield f"while {words[1]} with more than {short(strong)} {unit}", values < -strong
        yield f"while {words[2]} with less than {short(weak)} {unit}", np.abs(values) < weak


def _in_arms(found: Circumstances) -> Iterator[Condition]:
    several = len(found.wrenches) > 1
    for arm in found.wrenches:
        who, strength = f"arm {arm}" if several else "the arm", found.strength(arm)
        if several:
            strong = STRONG_SHARE * float(np.percentile(strength, LARGEST))
            yield f"while {who} gives more than {short(strong)} N", strength > strong
            yield f"while {who} gives most of the force", 2 * strength > sum(map(found.strength, found.wrenches))
        held = np.round(found.contacts[arm], 2)
        places = np.unique(held[np.isfinite(held).all(axis=1)], axis=0)
        for x, y in places if len(places) <= MOST_CONTACTS else ():
            yield f"while {who} holds at x = {x:.2f} m, y = {y:.2f} m of the cart", (held == (x, y)).all(axis=1)
