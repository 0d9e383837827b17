"""Wrench balance: which reading of the arms' wrenches goes with how the cart moved, whatever cart it is.

What a cart takes is linear in its parameters, and what arms give is linear in the gains by which each is to be read. So
sums of products over blocks tell how much the likeliest cart leaves unexplained in each reading: signs that are
reversed, of all arms or of one, and one arm's unit. All rows are held against the first guess, and the last ones
against what those before have taught: of a sensor that is turned over in a run no other cart is learned first. A load,
or another floor, may have come in between.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

import numpy as np

from cartgrasp.effects import UnknownSlope
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel

from ..gaussian import Gaussian
from ..sensor_check.evidence import UNEXPLAINED_FRACTION, evidence, probabilities
from ..sensor_check.suspicion import REFUSAL_PROBABILITY, Suspicion
from ..sensor_check.wrench_readings import COMMON_MOUNTING_ODDS
from .arguments import EstimatorArguments
from .competing_explanations import BLOCK_FORGETTING_FACTOR, MAX_SOUND_RESIDUAL_FRACTION, ROWS_PER_INDEPENDENT_ROW
from .load_change import load_covariance
from .regressor.mass_products import MassProducts
from .unknown_slope import with_unknown_slope

FORCE_UNITS = {"N": 1.0, "lbf": 4.4482216, "kgf": 9.80665, "kN": 1000.0}
"""N in each unit."""
FORCE_UNIT_ODDS = 0.003
"""Odds of each unit of force: rather less than of a log, as it is asked again and again, and a cart may be three times
as heavy as it was guessed to be."""
RECENT_ROWS, MIN_RECENT_ROWS = 12, 3.0
"""Last rows that are foretold by those before, 3 s of motion; and how many count at least before anything is told."""
RAMP_RATIO = 0.25
"""Standard deviation of a ramp, as a share of the steepest slope that is believed."""
NOISE_ITERATIONS = 3
"""By which noise is as large as what the likeliest cart leaves."""


class Reading(NamedTuple):
    """Gains (n,) by which wrenches of n arms are to be read, and the odds against reading them as they are."""

    kind: str
    where: str
    gains: Array
    odds: float


class Sums(NamedTuple):
    """Sums over rows: products of slopes by the parameters with each other (f, f) and with what arms give and the first
    guess takes (f, n + 1), and of these (n + 1, n + 1); and squares of the sizes of rows. Moments count as forces at
    the noise's lever."""

    information: Array
    pull: Array
    whole: Array
    squared: float

    @classmethod
    def of(cls, slopes: Array, values: Array) -> Sums:
        """One row's."""
        whole = values.T @ values
        return cls(slopes.T @ slopes, slopes.T @ values, whole, float(np.trace(whole)) ** 2)

    def and_then(self, row: Sums) -> Sums:
        """With newer rows, while older ones fade."""
        kept = BLOCK_FORGETTING_FACTOR
        return Sums(
            kept * self.information + row.information,
            kept * self.pull + row.pull,
            kept * self.whole + row.whole,
            kept**2 * self.squared + row.squared,
        )

    def read(self, gains: Array) -> Sums:
        """With what arms give times gains (n,)."""
        by = np.append(gains, 1.0)
        return self._replace(pull=self.pull * by, whole=self.whole * np.outer(by, by))

    @property
    def rows(self) -> float:
        """How many count: Kish's effective size."""
        size = float(np.trace(self.whole))
        return size * size / self.squared if self.squared > 0.0 else 0.0

    def after(self, before: Gaussian, gains: Array) -> Explained:
        """What is believed after them, with each of the gains (r, n), in the coordinates in which what is believed
        before is standard normal, and what rows tell of one says nothing of another."""
        reading = np.column_stack([gains, -np.ones(len(gains))])
        size = (gains @ self.whole[:-1, :-1] * gains).sum(axis=1) + 1e-12
        root = np.linalg.cholesky(before.covariance)
        told, turn = np.linalg.eigh(root.T @ self.information @ root)
        root, off = root @ turn, reading @ self.pull.T - self.information @ before.mean
        pulled, left = off @ root, np.zeros(len(gains))
        whole = (reading @ self.whole * reading).sum(axis=1) - (off + reading @ self.pull.T) @ before.mean
        for _ in range(NOISE_ITERATIONS):
            weight = self.rows / (ROWS_PER_INDEPENDENT_ROW * (left + UNEXPLAINED_FRACTION**2) * size)
            precision = 1.0 + weight[:, None] * told
            mean = weight[:, None] * pulled / precision
            left = np.maximum(whole + (mean * (told * mean - 2.0 * pulled)).sum(axis=1), 0.0) / size
        first = Gaussian(before.mean + root @ mean[0], root / precision[0] @ root.T)
        return Explained(first, left, (mean * mean).sum(axis=1))


class Explained(NamedTuple):
    """How far the parameters (f,) are believed to be from the first guess by the `first` of r readings; by each, the
    share (r,) of what arms give that stays unexplained, and the normalised square (r,) of what is believed beside what
    was before."""

    first: Gaussian
    left: Array
    square: Array


class WrenchBalance:
    """Follows how wrenches of arms, by name, are to be read: as they were before, unless rows tell."""

    def __init__(self, made_of: EstimatorArguments, arms: Sequence[str]) -> None:
        cart, _, noise, prior, _ = with_unknown_slope(made_of)
        free, at = prior.free(cart), cart.parameters
        products, places = MassProducts.of(cart, free), np.ix_(free, free)
        self._cart, self._scale = cart, noise.wrench_scale(cart)[:, None]
        self._by, by = products.jacobian(at)[:, free], products.by_factors(at)
        first = products.belief(Gaussian(at[free], prior.covariance(cart)[places]), free, at)
        self._first = Gaussian(np.zeros(len(free)), first.covariance)
        load = by @ load_covariance(cart, prior, cart.inertia.mass) @ by.T
        self._between = (load + products.floor(at) + _ramp(cart))[places]
        self._readings = _readings(arms)
        self._gains = np.array([one.gains for one in self._readings])
        self._odds = np.array([one.odds for one in self._readings])
        self._place = 0  # of the reading by which they are read now
        self._before: Sums | None = None
        self._recent: tuple[Sums, ...] = ()
        self._are_explained = True  # the last rows, as wrenches are read: what is not teaches nothing
        self.suspicions: tuple[Suspicion, ...] = ()

    @property
    def _now(self) -> Array:
        """The gains (n,) by which wrenches are read now."""
        return np.asarray(self._gains[self._place])

    def note(self, state: Array, rate: Array, time: float, given: Array) -> Array:
        """A row: a state of the cart and its nu' (k,) at a time (s), and what each arm gave, reduced (n, k). Returns
        what the first guess takes (k,)."""
        taken, slopes = self._cart.inverse_by_parameters(state, rate, time=time)
        row = Sums.of(slopes @ self._by / self._scale, np.column_stack([given.T, taken]) / self._scale)
        oldest, self._recent = self._recent[: 1 - RECENT_ROWS], (*self._recent[1 - RECENT_ROWS :], row)
        if oldest and self._are_explained:
            (more,) = oldest
            self._before = _joined(self._before, more.read(self._now))
        return taken

    def conclude_of_all(self) -> None:
        """Whether all rows go with another reading, and a cart as was guessed."""
        if not self._recent:
            return
        rows = _joined(self._before, reduce(Sums.and_then, self._recent).read(self._now))
        told = self._likeliest(rows.rows, rows.after(self._first, self._gains / self._now))
        if told is not None and self._before is not None:
            self._before = self._before.read(self._gains[told[0]] / self._now)
        self._go_on_with(told)

    def conclude_of_last(self) -> None:
        """Whether the last rows do, beside those before."""
        if self._before is None or not self._recent:
            return
        learned = self._before.after(self._first, self._gains[:1]).first
        before, rows = Gaussian(learned.mean, learned.covariance + self._between), reduce(Sums.and_then, self._recent)
        explained = rows.after(before, self._gains)
        self._are_explained = bool(explained.left[self._place] <= MAX_SOUND_RESIDUAL_FRACTION)
        told = self._likeliest(rows.rows, explained)
        self._go_on_with(told)
        if told is not None:
            self._recent = ()

    def _likeliest(self, rows: float, found: Explained) -> tuple[int, float] | None:
        """Another reading, with its probability, if there is one that goes with so many rows."""
        if not rows >= MIN_RECENT_ROWS:
            return None
        told = evidence(found.left, 1.0, len(self._scale) * rows / ROWS_PER_INDEPENDENT_ROW) - 0.5 * found.square
        odds = self._odds.copy()
        odds[self._place] = 1.0
        shares = probabilities(told, odds)
        best = int(np.argmax(shares))
        is_other = best != self._place and found.left[best] <= MAX_SOUND_RESIDUAL_FRACTION
        return (best, float(shares[best])) if is_other and shares[best] >= REFUSAL_PROBABILITY else None

    def _go_on_with(self, told: tuple[int, float] | None) -> None:
        if told is None:
            return
        self._place, probability = told
        self._are_explained = True
        self.suspicions = (_suspicion(self._readings[self._place], probability),) if self._place else ()


def _ramp(cart: CartModel) -> Array:
    """Covariance (p, p) of what a ramp adds to the products of a slope that nobody knows with the mass."""
    parameters = [(effect, one.upper) for effect in cart.effects for one in effect.parameters]
    usual = [RAMP_RATIO * upper if isinstance(effect, UnknownSlope) else 0.0 for effect, upper in parameters]
    return np.diag(np.square(cart.inertia.mass * np.array([0.0] * N_PHI + usual)))


def _joined(sums: Sums | None, more: Sums) -> Sums:
    """Older sums, if there are any, and newer ones."""
    return more if sums is None else sums.and_then(more)


def _readings(arms: Sequence[str]) -> tuple[Reading, ...]:
    """The sound one first."""
    sound = np.ones(len(arms))
    found = [Reading("", "", sound, COMMON_MOUNTING_ODDS), Reading("sign", "wrench", -sound, COMMON_MOUNTING_ODDS)]
    for arm, own in zip(arms if len(arms) > 1 else (), np.eye(len(arms)), strict=False):
        found.append(Reading("sign", arm, sound - 2.0 * own, COMMON_MOUNTING_ODDS))
        units = [factor for name, factor in FORCE_UNITS.items() if name != "N"]
        found += [Reading("unit", arm, sound + (factor - 1.0) * own, FORCE_UNIT_ODDS) for factor in units]
    return tuple(found)


def _suspicion(reading: Reading, probability: float) -> Suspicion:
    kind, where, gains, _ = reading
    factor = float(gains[np.argmax(np.abs(gains - 1.0))])
    if kind == "unit":
        (unit,) = (name for name, one in FORCE_UNITS.items() if one == factor)
        words = f"{where}: its wrench seems to be in {unit}, not N, beside the others'"
    elif where == "wrench":
        words = "wrenches work against the cart: they are its own on the hands, or their sign is reversed"
    else:
        words = f"{where}: its wrench works against the cart while others push: its sign is reversed"
    return Suspicion(kind, where, probability, factor, words)
