"""Where and when simulation and measurement disagree, in sentences that a person can act on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import rel_entr

from .circumstances import Circumstances
from .course import ROLLING, Course
from .residual import UNITS, Residual
from .residual_map import profiles

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
    coordinate's unit) and its share of the coordinate's whole disagreement. `intervals` (s): when, between `start` and
    `stop`, the condition holds."""

    start: float
    stop: float
    coordinate: str
    condition: str
    size: float
    share: float
    intervals: tuple[tuple[float, float], ...] = ()

    @property
    def sentence(self) -> str:
        """For people."""
        coordinate = self.coordinate.replace("_", " ").capitalize()
        return f"{coordinate}, {short(self.size)} {UNITS[self.coordinate]}: {self.condition}"


def where(residuals: Sequence[Residual]) -> list[Disagreement]:
    """The conditions that gather the disagreement, those first that tell the most: by how much more of it they hold
    than of the time. Then what else it goes along with."""
    there = [residual for residual in residuals if residual.disagrees]
    along = [told for residual in there for told in _along(residual)]
    found = sorted((told for residual in there for told in _gathering(residual)), key=lambda told: -told[0])
    return [*(one for _, one in found[: MOST - len(along)]), *along]


def _gathering(residual: Residual) -> Iterator[tuple[float, Disagreement]]:
    """With what they tell (nats), but for what says the same as one that tells more."""
    total, told, others = float(residual.beyond.sum()), [], list[np.ndarray]()
    for words, chosen in _telling(residual):
        share, of_time = float(np.clip(residual.beyond[chosen].sum() / total, 0.0, 1.0)), float(chosen.mean())
        if 0 < of_time < 1 and share >= LEAST_SHARE and share >= LEAST_LIFT * of_time:
            known = float(rel_entr(share, of_time) + rel_entr(1 - share, 1 - of_time))
            text = f"{100 * share:.0f} % of the misfit lies {words} ({100 * of_time:.0f} % of the time)"
            told.append((known, chosen, share, text))
    for known, chosen, share, text in sorted(told, key=lambda one: -one[0]):
        if not any(_says(residual, other, chosen) for other in others):
            others.append(chosen)
            yield known, _disagreement(residual, chosen, share, text)


def _disagreement(residual: Residual, chosen: np.ndarray, share: float, text: str) -> Disagreement:
    """From when to when stretches lie, in the log that holds the most of their disagreement."""
    logs = np.where(chosen, residual.circumstances.log, -1)
    most = max(np.unique(logs[chosen]), key=lambda k: float(residual.beyond[logs == k].sum()))
    start, size = residual.start[logs == most], float(np.sqrt((residual.value[chosen] ** 2).mean()))
    runs = _runs(start, residual.duration)
    return Disagreement(runs[0][0], runs[-1][1], residual.coordinate, text, size, share, runs)


def _runs(start: np.ndarray, duration: float) -> tuple[tuple[float, float], ...]:
    """From when to when stretches (n,) of one duration (s) follow one another, in order of time."""
    start = np.sort(start)
    pieces = np.split(start, np.flatnonzero(np.diff(start) > 1.5 * duration) + 1)
    return tuple((float(piece[0]), float(piece[-1]) + duration) for piece in pieces)


def _along(residual: Residual) -> Iterator[Disagreement]:
    """What the residual goes along with the most, be it forward or backward, where that is most of it."""
    found = [(float(np.nansum((one.mean / one.std) ** 2 - 1.0)), one) for one in profiles(residual)]
    share, best = max(found, key=lambda each: each[0], default=(0.0, None))
    share = min(share / float(residual.beyond.sum()), 1.0)
    if best is not None and share >= LEAST_ALONG:
        ends = sorted((int(np.nanargmin(best.mean)), int(np.nanargmax(best.mean))))
        told = (f"{short(best.mean[k])} {residual.unit} at {short(best.at[k])} {best.unit}" for k in ends)
        text = f"{100 * share:.0f} % of the misfit goes with the {best.variable}: {', '.join(told)}"
        yield _disagreement(residual, np.ones(len(residual.start), dtype=bool), share, text)


def _says(residual: Residual, told: np.ndarray, chosen: np.ndarray) -> bool:
    """Whether one condition says what another does: what this holds lies there."""
    within = residual.beyond[told & chosen].sum() > MOST_KNOWN * residual.beyond[chosen].sum()
    return bool(within and told.sum() <= WIDER * chosen.sum())


def _telling(residual: Residual) -> Iterator[Condition]:
    """Without what holds whenever the cart moves, such as that it rolls forward, if it never does otherwise."""
    course = residual.circumstances.course
    moves = (np.abs(course.speed) > ROLLING) | (np.abs(course.yaw_rate) > TURNING)
    yield "while it moves", moves
    for words, chosen in _conditions(residual):
        if (chosen & moves).sum() < ALL_MOTION * moves.sum() or not moves.any():
            yield words, chosen


def _conditions(residual: Residual) -> Iterator[Condition]:
    found = residual.circumstances
    yield from _in_motion(found)
    yield from _in_time(residual)
    yield from _in_place(found.course)
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
        own = found.log == k
        of_log = f" of {name}" if len(found.names) > 1 else ""
        if of_log:
            yield f"in {name}", own
        begins, ways, changes = start[own], found.course.travelled[own], residual.changes[k]
        for change in changes:
            at = f"t = {begins[change]:.1f} s{of_log}, {ways[change]:.1f} m of its way"
            yield f"after {at}", own & (start >= begins[change])
            yield f"before {at}", own & (start < begins[change])
        for first, end in zip([0, *changes], [*changes, len(begins)], strict=True):
            begin, last = begins[first], begins[end - 1]
            at = f"t = {begin:.1f} s to {last + residual.duration:.1f} s{of_log}"
            way = f"{ways[first]:.1f} to {ways[end - 1]:.1f} m of its way"
            yield f"from {at}, {way}", own & (start >= begin) & (start <= last)


def _in_place(course: Course) -> Iterator[Condition]:
    """In squares of a metre, and along quarters of the circle."""
    squares, number = np.unique(np.floor(course.place), axis=0, return_inverse=True)
    for k, (x, y) in enumerate(squares):
        yield f"where x is {x:.0f} to {x + 1:.0f} m and y {y:.0f} to {y + 1:.0f} m", number.ravel() == k
    quarter = np.round(course.heading / (np.pi / 2)) % 4
    for k, name in enumerate(("+x", "+y", "-x", "-y")):
        yield f"while it heads along the floor's {name}", quarter == k


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
