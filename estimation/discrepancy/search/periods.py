"""Forces and moments that repeat after a period in time, way or place: found by a Fourier transform of what pulls at a
model, summed over harmonics of each period (as pulsars are searched for; de Jager et al., 1989), then by columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.effects import LearnedForce
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.wheels import FIXED

from ...weak_form.balances import Balances
from ...weak_form.integrals import GRID_STRIDE
from .covariates import Covariates
from .laws import AT_HANDS, Law, both_ways, seen_values
from .model import Model

SCANNED_VARIABLES = (
    ("time", 0.0, 0.25, 4.0),
    ("way", 0.0, 0.25, 2.5),
    ("x", 0.0, 0.3, 2.0),
    ("y", np.pi / 2, 0.3, 2.0),
)
"""Variables of a course, which way they go in the world, and between which periods a law is looked for."""
LAW_VARIABLE_OF = {"time": "time", "way": "travelled_distance", "x": "place", "y": "place"}
SCANNED_FORCES = ("forward_force", "world_force", "yaw_moment")
LAW_HARMONICS = (1, 2, 4, 8)
"""Numbers of harmonics of a law: a pulse to and fro has more of the higher ones than of the first."""
FOURIER_OVERSAMPLING = 8
"""Points of a Fourier transform's grid in the shortest period of a harmonic."""
INFORMATION_FREQUENCIES, MAX_SCORED_PERIODS = 24, 16
"""Frequencies of a scan of which the information is worked out, and periods of which then the gain is."""


@dataclass(frozen=True, eq=False)
class Scan:
    """Scan of forces like one of a law, over a variable of a course, with frequencies (v,) that increase; `highest` is
    the highest of a harmonic."""

    variable: str
    effect: LearnedForce
    place: str
    frequencies: Array
    highest: float

    def law(self, period: float, harmonics: int = 1, has_mean: bool = False) -> Law:
        """Law of so many harmonics, about nought or a mean."""
        numbers = tuple(float(k) for k in range(0 if has_mean else 1, harmonics + 1))
        form = self.place + (f" of {harmonics} harmonics" if harmonics > 1 else "") + (", with a mean" * has_mean)
        law = Law.free(form, replace(self.effect, period=period, harmonics=numbers, amplitudes=()))
        law = replace(law, basis=np.delete(law.basis, 1, axis=1)) if has_mean else law
        is_of_world = self.variable == "time" and self.effect.acts_on == "world_force"
        return both_ways(form, law.effects[0], law.basis) if is_of_world else law

    def of(self, course: Covariates) -> Array:
        """The variable (n,) where the force is."""
        turned = self.effect.lever * course.heading * (self.variable == "way")
        return np.asarray(getattr(course, self.variable) - turned)

    def columns(
        self, frequencies: Array, harmonics: int, course: Covariates, balances: Balances, cart: CartModel
    ) -> Array:
        """Raw columns (k, c, v, 2 h) of cosines and sines of frequencies (v,) and so many harmonics of each."""
        turns = np.multiply.outer(frequencies, np.arange(1, harmonics + 1))
        return _waves(self.of(course), _unit(self.effect, course, cart.constraints.n_free), turns, balances, cart)

    @property
    def spacing(self) -> float:
        """From one frequency to the next."""
        return float(self.frequencies[1] - self.frequencies[0])

    def power(self, courses: Sequence[Covariates], pulls: Sequence[Array]) -> tuple[Array, Array]:
        """How much pulls (n, f) of the residual on forces and moments along the courses go with each of frequencies
        (v,), up to the highest, and these: by a fast Fourier transform of pulls over the variable, each shared by the
        two nearest of its grid's points."""
        step = 1 / (FOURIER_OVERSAMPLING * self.highest)
        first = min(float(self.of(c).min()) for c in courses)
        count = round(1 / (step * self.spacing))
        total = np.zeros(count)
        for course, pull in zip(courses, pulls, strict=True):
            at = (self.of(course) - first) / step
            low = np.floor(at).astype(int)
            signal = (pull * _unit(self.effect, course, pull.shape[1])).sum(axis=1)
            for where, share in ((low, 1 - (at - low)), (low + 1, at - low)):
                total += np.bincount(where % count, weights=signal * share, minlength=count)
        frequencies = np.asarray(np.fft.rfftfreq(count, step), dtype=float)
        frequencies = frequencies[frequencies <= self.highest]
        return np.asarray(np.abs(np.fft.rfft(total)[: len(frequencies)]) ** 2), frequencies

    def combs(self, gains: Array, frequencies: Array) -> list[tuple[float, float, int]]:
        """Gains, frequencies and numbers of harmonics at which the sum of harmonics' own gains (v,) at frequencies (v,)
        is as large as at both neighbours: a harmonic's peak is as many times narrower as its number says."""
        found = list[tuple[float, float, int]]()
        for harmonics in LAW_HARMONICS:
            most = min(float(self.frequencies[-1]), self.highest / harmonics)
            each = np.arange(self.frequencies[0], most, self.spacing / harmonics)
            total = np.sum([np.interp(k * each, frequencies, gains) for k in range(1, harmonics + 1)], axis=0)
            inside = total[1:-1]
            peaks = 1 + np.flatnonzero((inside >= total[:-2]) & (inside >= total[2:]))
            found += [(float(total[i]), float(each[i]), harmonics) for i in peaks]
        return found


def _waves(variable: Array, unit: Array, turns: Array, balances: Balances, cart: CartModel) -> Array:
    """Raw columns (k, c, v, 2 h) of cosines and sines of a variable (n,), of frequencies (v, h), in the free directions
    (n, f) of a unit."""
    pushed = np.flatnonzero(unit.any(axis=0))

    def waves(at: slice) -> Array:
        phase = variable[at, None, None] * (2 * np.pi * turns)
        both = np.concatenate([np.cos(phase), np.sin(phase)], axis=2)
        return np.asarray(unit[at][:, pushed, None, None] * both[:, None])

    found = np.zeros((len(balances.used), balances.n_balances(cart), turns.shape[0], 2 * turns.shape[1]))
    found[:, pushed] = balances.integrals.by_parts(waves, is_thin=True)
    return found


def _unit(effect: LearnedForce, course: Covariates, free: int) -> Array:
    """What a unit of the force gives in the free directions (n, f)."""
    angle, found = effect.direction - course.heading, np.zeros((len(course.time), free))
    if effect.acts_on == "yaw_moment":
        found[:, -1] = 1.0
        return found
    is_of_world = effect.acts_on == "world_force"
    if free > 1:
        found[:, -1] = effect.ahead * np.sin(angle) if is_of_world else -effect.lever
    found[:, 0] = np.cos(angle) if is_of_world else 1.0
    return found


def is_like_a_scans(effect: LearnedForce) -> bool:
    """Whether it repeats, and is a force or a moment, not a drag, of what is scanned."""
    return bool(effect.period) and effect.of in LAW_VARIABLE_OF.values() and effect.acts_on in SCANNED_FORCES


def waves(effect: LearnedForce, frequencies: Array, balances: Balances, cart: CartModel) -> Array:
    """Raw columns (k, c, v, 2) of cosines and sines of frequencies (v,) of a force like one that repeats."""
    variable, course = seen_values(effect, [balances.motion]), Covariates.along(balances.motion)
    return _waves(variable, _unit(effect, course, cart.constraints.n_free), frequencies[:, None], balances, cart)


def scans(courses: Sequence[Covariates], cart: CartModel, hands: float, resolved: float) -> list[Scan]:
    """Scans that a motion allows: periods of which it saw two at least, and waves of which `resolved` turns at most go
    by from one point of it to the next; with a lever of the hands' (m; none: 0)."""
    found, turns = [], cart.constraints.n_free > 1
    levers = [wheel.y for wheel in cart.wheels if wheel.kind == FIXED and wheel.y] if turns else []
    for variable, direction, least, most in SCANNED_VARIABLES:
        span = max(float(np.ptp(getattr(c, variable))) for c in courses)
        if span < 2 * least or (variable in "xy" and not turns):
            continue
        force = LearnedForce("forward_force", LAW_VARIABLE_OF[variable], period=1.0)
        if variable in "xy":
            force = replace(force, acts_on="world_force", direction=direction)
        places = [(force, "force")]
        if variable == "time" and turns:  # at the CoM, as what shakes the floor
            shaken = replace(force, acts_on="world_force", ahead=float(cart.inertia.com[0]))
            places += [(replace(shaken, direction=way), "force of the world") for way in (0.0, np.pi / 2)]
        places += [(replace(force, acts_on="yaw_moment"), "moment")] if turns else []
        places += [(replace(force, lever=hands), f"force {AT_HANDS}")] if hands and variable not in "xy" else []
        for y in levers if variable == "way" else ():
            places += [(replace(force, lever=y), f"force at the wheel at y = {y:g} m")]
            places += [(replace(force, acts_on="yaw_moment", lever=y), f"moment of the wheel at y = {y:g} m")]
        frequencies = np.arange(1 / min(most, span / 2), 1 / least, 0.4 / span)
        fastest = max(float(np.abs(np.gradient(getattr(c, variable))).max()) for c in courses)
        highest = min(LAW_HARMONICS[-1] / least, resolved / max(fastest, 1e-12))
        if len(frequencies) > 1 and highest > 2 * frequencies[0]:
            found += [Scan(variable, effect, place, frequencies, highest) for effect, place in places]
    return found


def coarse_columns(law: Law, balances: Balances, cart: CartModel) -> Array:
    """`law.columns` (k, c, q) of one that is like a scan's, by sums along the motion as coarse as the scan's."""

    def of_one(effect: LearnedForce) -> Array:
        found = waves(effect, np.array(effect.harmonics) / effect.period, balances, cart)
        return -found.reshape(*found.shape[:2], -1)

    return law.of_amplitudes(of_one)


ScoredPeriod = tuple[float, Scan, float, int]
"""A gain, the scan that has it, its period and number of harmonics."""


def scanned(
    model: Model, pulls: Sequence[Array], gain: Callable[[Array, Array], Array], hands: float = 0.0
) -> tuple[list[list[ScoredPeriod]], int]:
    """In each scan the best period for each number of harmonics, and the number of periods scanned. They are among
    those of which the powers of all harmonics gain most for the information that a model's rows have."""
    logs, cart, found, count = model.logs, model.cart, list[list[ScoredPeriod]](), 0
    courses = [replace(Covariates.along(balances.motion), time=balances.motion.time) for balances in logs]
    resolved = min(1 / GRID_STRIDE - b.motion.step / b.row_step for b in logs)  # no wave passes for slow

    def columns(scan: Scan, frequencies: Array, harmonics: int) -> Array:
        """Whitened columns (v, k, c, 2 h)."""
        raw = [scan.columns(frequencies, harmonics, course, b, cart) for course, b in zip(courses, logs, strict=True)]
        white = model.whitened([one.reshape(*one.shape[:2], -1) for one in raw])
        return np.moveaxis(white.reshape(*white.shape[:2], len(frequencies), 2 * harmonics), 2, 0)

    for scan in scans(courses, cart, hands, resolved):
        std = scan.effect.parameters[0].typical
        power, frequencies = scan.power(courses, pulls)
        known = np.geomspace(scan.frequencies[0], scan.highest, INFORMATION_FREQUENCIES)
        told = (columns(scan, known, 1) / model.score.scale[:, None]) ** 2
        information = np.interp(frequencies, known, told.sum(axis=(1, 2, 3)))
        own = power / (information + 2 / std**2) - np.log1p(std**2 * information / 2)
        count += len(scan.frequencies) * sum(LAW_HARMONICS)
        best = dict[int, ScoredPeriod]()
        for _, frequency, harmonics in sorted(scan.combs(own, frequencies), reverse=True)[:MAX_SCORED_PERIODS]:
            gained = float(gain(columns(scan, np.array([frequency]), harmonics), np.full(2 * harmonics, std))[0])
            if harmonics not in best or gained > best[harmonics][0]:
                best[harmonics] = gained, scan, 1 / frequency, harmonics
        if best:
            found.append(sorted(best.values(), key=lambda one: -one[0]))
    return found, count
