"""Where and when simulation and measurement disagree, in sentences that a person can act on: in which conditions, along
with what, and while what was named acts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.special import rel_entr

from cartgrasp.effects import ConstraintEffect, Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.frames import Array

from ...weak_form.balances import Balances
from ...weak_form.wheel_tracks import touches
from ..search.covariates import MIN_DIRECTED_SPEED, Covariates
from ..search.gains import added
from ..search.laws import Law
from ..search.model import Model
from .circumstances import Circumstances
from .residual import RESIDUAL_UNITS, Residual
from .residual_map import means, strongest_dependence

MIN_CONDITION_FRACTION, MIN_CONDITION_LIFT = 0.25, 1.4
"""Least share of the disagreement in a condition worth telling, and the least multiple of its share of the time."""
MIN_DEPENDENCE_FRACTION = 0.5
"""Least share of the disagreement that goes with a variable worth telling."""
MAX_SENTENCES, PARTS_PER_PERIOD = 5, 12
"""Most sentences; parts of a period."""
MAX_OVERLAP_FRACTION, MAX_OVERLAP_WIDTH_RATIO = 0.8, 1.25
"""A condition says nothing new if this share of its disagreement lies in a told one that is at most so many times as
wide."""
SLOW_SPEED, TURNING_RATE = 0.12, 0.08
"""Speed (m/s) below which a cart is slow; yaw rate (rad/s) above which it turns."""
FAST_SPEED_FRACTION, STRONG_WRENCH_FRACTION, WEAK_WRENCH_FRACTION = 0.75, 0.7, 0.2
"""Share of the fastest speed above which a cart is fast; shares of the largest force or moment for strong and weak
ones."""
LARGEST_PERCENTILE = 98.0
"""Percentile: what is larger is an accident."""
AFTER_REVERSAL_DISTANCE, WORST_HALF_INTERVAL = 0.4, 0.5
"""Distance (m) after a reversal; time (s) about the worst stretch."""
MAX_LISTED_CONTACTS = 6
GATE_WORDS = {Gate.WHILE: "while", Gate.FROM: "from when", Gate.INSIDE: "where"}


def short(value: float) -> str:
    """A value with two digits, without an exponent where there need be none: 230 and not 2.3e+02."""
    return f"{float(f'{value:.2g}'):g}"


Intervals = tuple[tuple[float, float], ...]
"""Begins and ends (s), in order of time."""
Condition = tuple[str, np.ndarray]
"""A condition in words, and whether stretches (b,) meet it."""


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
    intervals: Intervals = ()

    @property
    def sentence(self) -> str:
        """The disagreement in a sentence for people."""
        coordinate = self.coordinate.replace("_", " ").capitalize()
        return f"{coordinate}, {short(self.size)} {RESIDUAL_UNITS[self.coordinate]}: {self.condition}"


def where(residuals: Sequence[Residual], first: Sequence[Disagreement] = ()) -> list[Disagreement]:
    """The few things that tell the most: what is known `first`, then conditions that gather it, by how much more of it
    they hold than of the time, after what it goes along with where that tells more of it than any, else before."""
    found = list[tuple[float, Disagreement]]()
    for residual in (residual for residual in residuals if residual.disagrees):
        gathered = list(_gathering(residual))
        most = max((one.share for _, one in gathered), default=0.0)
        found += [*gathered, *((np.inf if one.share > most else 0.0, one) for one in _along(residual))]
    return [*first, *(one for _, one in sorted(found, key=lambda told: -told[0]))][:MAX_SENTENCES]


def _gathering(residual: Residual) -> Iterator[tuple[float, Disagreement]]:
    """Conditions that gather the disagreement, with how much they tell. Left out is what says the same as one that
    tells more, or as all motion does."""
    course, told, others = residual.circumstances.covariates, [], list[np.ndarray]()
    moves = (np.abs(course.speed) > MIN_DIRECTED_SPEED) | (np.abs(course.yaw_rate) > TURNING_RATE)
    total = max(float(residual.beyond[moves].sum()), 1e-12)
    for words, condition in _conditions(residual):
        chosen = condition & moves
        share = float(np.clip(residual.beyond[chosen].sum() / total, 0.0, 1.0))
        of_time = float(chosen.sum() / max(moves.sum(), 1))
        if 0 < of_time < 1 and share >= MIN_CONDITION_FRACTION and share >= MIN_CONDITION_LIFT * of_time:
            known = total * float(rel_entr(share, of_time) + rel_entr(1 - share, 1 - of_time))
            text = f"{100 * share:.0f} % of the misfit lies {words} ({100 * of_time:.0f} % of the time on the move)"
            told.append((known, chosen, share, text))
    for known, chosen, share, text in sorted(told, key=lambda one: -one[0])[:MAX_SENTENCES]:
        if not any(_is_covered(residual, other, chosen) for other in others):
            others.append(chosen)
            yield known, _disagreement(residual, chosen, share, text)


def repeats(residual: Residual, values: Array, law: Law) -> Iterator[Disagreement]:
    """How much of single rows' disagreement repeats with a law's period over values (b,) of its variable; nothing where
    that is little."""
    if not (law.period and residual.disagrees):
        return
    at, mean, std = means(residual, values % law.period, np.linspace(0.0, law.period, PARTS_PER_PERIOD + 1))
    share = float(np.nansum((mean / std) ** 2 - 1.0) / residual.beyond.sum())
    if share >= MIN_CONDITION_FRACTION:
        low, high = int(np.nanargmin(mean)), int(np.nanargmax(mean))
        told = (f"{short(mean[k])} {residual.unit} at {short(at[k])} {law.unit} of it" for k in (low, high))
        text = f"{100 * min(share, 1.0):.0f} % of the misfit repeats every {law.period:.3g} {law.unit} of {law.name}: "
        every = np.ones(len(residual.start), dtype=bool)
        yield _disagreement(residual, every, min(share, 1.0), text + ", ".join(told))


def _disagreement(residual: Residual, chosen: np.ndarray, share: float, text: str) -> Disagreement:
    """Disagreement of the chosen stretches, with the times of those in the log that holds the most of it."""
    logs = np.where(chosen, residual.circumstances.log, -1)
    most = max(np.unique(logs[chosen]), key=lambda k: float(residual.beyond[logs == k].sum()))
    return _in_intervals(residual, chosen, share, text, _runs(residual.start[logs == most], residual.duration))


def _in_intervals(residual: Residual, chosen: np.ndarray, share: float, text: str, when: Intervals) -> Disagreement:
    size = float(np.sqrt((residual.value[chosen] ** 2).mean()))
    return Disagreement(when[0][0], when[-1][1], residual.coordinate, text, size, share, when)


def _runs(start: np.ndarray, duration: float) -> Intervals:
    """Runs of stretches (n,) of one duration (s) that follow one another."""
    start = np.sort(start)
    pieces = np.split(start, np.flatnonzero(np.diff(start) > 1.5 * duration) + 1)
    return tuple((float(piece[0]), float(piece[-1]) + duration) for piece in pieces)


def _along(residual: Residual) -> Iterator[Disagreement]:
    """What the residual goes along with the most, where that is most of it; time only where nothing else comes near."""
    share, best = strongest_dependence(residual)
    other, steadier = strongest_dependence(residual, but="time")
    if other >= MAX_OVERLAP_FRACTION * share:
        share, best = other, steadier
    if best is not None and share >= MIN_DEPENDENCE_FRACTION:
        ends = sorted((int(np.nanargmin(best.mean)), int(np.nanargmax(best.mean))))
        told = (f"{short(best.mean[k])} {residual.unit} at {short(best.at[k])} {best.unit}" for k in ends)
        text = f"{100 * share:.0f} % of the misfit goes with the {best.variable}: {', '.join(told)}"
        yield _disagreement(residual, np.ones(len(residual.start), dtype=bool), share, text)


def _is_covered(residual: Residual, told: np.ndarray, chosen: np.ndarray) -> bool:
    """Whether one condition says what another does: what this holds lies there."""
    within = residual.beyond[told & chosen].sum() > MAX_OVERLAP_FRACTION * residual.beyond[chosen].sum()
    return bool(within and told.sum() <= MAX_OVERLAP_WIDTH_RATIO * chosen.sum())


def _conditions(residual: Residual) -> Iterator[Condition]:
    found = residual.circumstances
    yield from _in_motion(found.covariates)
    yield from _in_time(residual)
    if found.wrenches:
        yield from _in_force(found)


def _in_motion(course: Covariates) -> Iterator[Condition]:
    """Conditions of how the cart moves, along which quarter of the circle, and in which square metre."""
    speed, turning = course.speed, course.yaw_rate
    moving, fast = np.abs(speed) > MIN_DIRECTED_SPEED, FAST_SPEED_FRACTION * float(np.abs(speed).max())
    yield (
        f"within {AFTER_REVERSAL_DISTANCE} m after a reversal",
        moving & (course.since_reversal < AFTER_REVERSAL_DISTANCE),
    )
    yield "while it rolls forward", speed > MIN_DIRECTED_SPEED
    yield "while it rolls backward", speed < -MIN_DIRECTED_SPEED
    yield f"below {SLOW_SPEED} m/s", moving & (np.abs(speed) < SLOW_SPEED)
    yield f"above {fast:.2f} m/s", np.abs(speed) > fast
    yield "while it turns left", turning > TURNING_RATE
    yield "while it turns right", turning < -TURNING_RATE
    yield "while it goes straight", moving & (np.abs(turning) <= TURNING_RATE)
    for k, name in enumerate(("+x", "+y", "-x", "-y")):
        yield f"while it heads along the floor's {name}", np.round(course.heading / (np.pi / 2)) % 4 == k
    squares, number = np.unique(np.floor(course.place), axis=0, return_inverse=True)
    for k, (x, y) in enumerate(squares):
        yield f"where x is {x:.0f} to {x + 1:.0f} m and y {y:.0f} to {y + 1:.0f} m", number.ravel() == k


def _in_time(residual: Residual) -> Iterator[Condition]:
    """Conditions of time: about the worst of each log, between change points, and before and after each."""
    found, start = residual.circumstances, residual.start
    for k, name in enumerate(found.names):
        own, of_log = found.log == k, f" of {name}" if len(found.names) > 1 else ""
        if of_log:
            yield f"in {name}", own
        begins, ways, changes = start[own], found.covariates.travelled[own], residual.changes[k]
        worst = begins[int(np.argmax(residual.beyond[own]))]
        yield (
            f"at t = {worst:.1f} s{of_log} or within {WORST_HALF_INTERVAL} s",
            own & (np.abs(start - worst) <= WORST_HALF_INTERVAL),
        )
        for change in changes:
            at = f"t = {begins[change]:.1f} s{of_log}, {ways[change]:.1f} m of its way"
            yield f"after {at}", own & (start >= begins[change])
            yield f"before {at}", own & (start < begins[change])
        for first, end in pairwise((0, *changes, len(begins))):
            begin, last = begins[first], begins[end - 1]
            at = f"t = {begin:.1f} s to {last + residual.duration:.1f} s{of_log}"
            way = f"{ways[first]:.1f} to {ways[end - 1]:.1f} m of its way"
            yield f"from {at}, {way}", own & (start >= begin) & (start <= last)


def _in_force(found: Circumstances) -> Iterator[Condition]:
    """Conditions of what all arms give together, what each gives where there are several, and where it holds."""
    for values, unit, more, less, little in (
        (found.total[:, 0], "N", "push it forward", "pull it backward", "push or pull"),
        (found.total[:, 2], "N·m", "turn it to the left", "turn it to the right", "turn it"),
    ):
        most = float(np.percentile(np.abs(values), LARGEST_PERCENTILE))
        strong, weak = STRONG_WRENCH_FRACTION * most, WEAK_WRENCH_FRACTION * most
        yield f"while the arms {more} with more than {short(strong)} {unit}", values > strong
        yield f"while the arms {less} with more than {short(strong)} {unit}", values < -strong
        yield f"while the arms {little} with less than {short(weak)} {unit}", np.abs(values) < weak
    several, whole = len(found.wrenches) > 1, sum(map(found.strength, found.wrenches))
    for arm in found.wrenches:
        who, strength = f"arm {arm}" if several else "the arm", found.strength(arm)
        if several:
            strong = STRONG_WRENCH_FRACTION * float(np.percentile(strength, LARGEST_PERCENTILE))
            yield f"while {who} gives more than {short(strong)} N", strength > strong
            yield f"while {who} gives most of the force", 2 * strength > whole
        held = np.round(found.contacts[arm], 2)
        places = np.unique(held[np.isfinite(held).all(axis=1)], axis=0)
        for x, y in places if len(places) <= MAX_LISTED_CONTACTS else ():
            yield f"while {who} holds at x = {x:.2f} m, y = {y:.2f} m of the cart", (held == (x, y)).all(axis=1)


def effect_disagreements(model: Model, residuals: Sequence[Residual]) -> Iterator[Disagreement]:
    """Disagreement of each effect of a model that does not act everywhere, in the coordinate in which it shows most."""
    for effect in added(model):
        if effect.gate.n_parameters and not isinstance(effect, ConstraintEffect):
            there = [residual for residual in residuals if residual.disagrees] or residuals
            told = [one for residual in there for one in _acting(effect, model, residual)]
            if told:
                yield max(told, key=lambda one: one[0])[1]


def _acting(effect: Effect, model: Model, residual: Residual) -> Iterator[tuple[float, Disagreement]]:
    """Disagreement in the log in which an effect acts for the longest time, with how far beyond noise it is there
    (squares)."""
    masks = [_acts(effect, balances, model) for balances in model.logs]
    balances, mask = max(zip(model.logs, masks, strict=True), key=lambda one: one[1].sum() * one[0].motion.step)
    motion, middle = balances.motion, residual.start + residual.duration / 2
    own = np.array([name == balances.name for name in residual.circumstances.names])[residual.circumstances.log]
    own &= (middle >= motion.time[0]) & (middle <= motion.time[-1])
    chosen = own & mask[np.clip(np.searchsorted(motion.time, middle), 0, len(mask) - 1)]
    if chosen.any():
        beyond = float(residual.beyond[chosen].sum())
        share = float(np.clip(beyond / max(residual.beyond.sum(), 1e-12), 0.0, 1.0))
        when = _runs(motion.time[mask], motion.step)
        span = f"t = {when[0][0]:.1f} to {when[-1][1]:.1f} s"
        text = f"{100 * share:.0f} % of the misfit lies {GATE_WORDS[effect.gate]} {effect.name} acts, {span}"
        yield beyond, _in_intervals(residual, chosen, share, text, when)


def _acts(effect: Effect, balances: Balances, model: Model) -> np.ndarray:
    """Whether (n,) an effect acts at each time of the motion."""
    time, values = balances.motion.time, effect.values
    if effect.gate is Gate.INSIDE:
        return touches(balances.motion.pose, values[:4], model.cart.wheel_set)
    end = values[0] + values[1] if effect.gate is Gate.WHILE else np.inf
    return np.asarray((time >= values[0]) & (time <= end))
