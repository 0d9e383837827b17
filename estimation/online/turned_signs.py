"""Signs of wrenches that turn while a cart is pushed: forces of the last seconds, against what rows before them taught
of the cart's inertia and friction.

Over all rows, it takes until the wrong ones outweigh the others. Rival explanations of the last rows hold from one of
them on: the arms' signs have turned, or something else pushes half of the time. Or a constant force does so in some of
them, as a person or a slope has it. Errors are normal, but for a few. Rows whose signs have turned are turned back, so
that the next are held against what sound sensors say.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array

from ..sensor_check.evidence import UNEXPLAINED_FRACTION, probabilities
from ..sensor_check.suspicion import REFUSAL_PROBABILITY
from ..sensor_check.wrench_readings import COMMON_MOUNTING_ODDS
from .competing_explanations import (
    BLOCK_FORGETTING_FACTOR,
    MAX_UNEXPLAINED_FRACTION,
    MIN_EVIDENCE_ROWS,
    ROWS_PER_INDEPENDENT_ROW,
)
from .kernels.jit import Indices
from .power_balance import PowerBalance

RECENT_ROWS = 24
"""Rows, a block (0.25 s) each, in which signs may have turned."""
OUTLIER_FRACTION, DISTURBED_FRACTION = 0.1, 0.5
"""Shares of rows in which something else may push, usually and while something disturbs."""
SHARED_ERROR_ROWS = 6.0
"""Times the variance that an error is given which all rows share: they tell of it no more than few do."""
LEAST_GAINED = math.log(REFUSAL_PROBABILITY / (1.0 - REFUSAL_PROBABILITY) / COMMON_MOUNTING_ODDS * RECENT_ROWS)
"""The least log-likelihood ratio with which a turn is told."""
TINY = 1e-9
"""(N·m/s)²: of no force."""


@dataclass(frozen=True)
class ForceRow:
    """Powers (2 + arms,), W, of what inertia and friction of the first guess take and arms give. And these as reduced
    wrenches (2 and arms, f), times the speed (m/s), so that a cart at rest tells nothing."""

    powers: Array
    take: Array
    give: Array
    speed: float

    def turned(self, signs: Array) -> ForceRow:
        powers = np.append(self.powers[:2], signs * self.powers[2:])
        return replace(self, powers=powers, give=signs[:, None] * self.give)


@dataclass(frozen=True)
class TurnedSigns:
    """The `signs` (arms,) by which arms' wrenches are taken, and how sure that is, with the last `rows`, and
    sums over those before, which count as so many: `products` (2 + arms, 2 + arms) of powers, and `forces` (f, 3, 3),
    of the forces by the speed that inertia, friction and all arms have. What else may push is of a variance `push`
    (f,)."""

    products: Array
    forces: Array
    signs: Array
    push: Array
    count: float = 0.0
    rows: tuple[ForceRow, ...] = ()
    probability: float = 1.0

    @classmethod
    def of(cls, arms: int, push: Array) -> TurnedSigns:
        return cls(np.zeros((2 + arms, 2 + arms)), np.zeros((len(push), 3, 3)), np.ones(arms), push)

    def and_then(self, row: ForceRow) -> TurnedSigns:
        """With one row more, before it is judged."""
        after = replace(self, rows=(*self.rows, row.turned(self.signs)))
        return after._without_first() if len(after.rows) > RECENT_ROWS else after

    @property
    def all_rows(self) -> tuple[Array, float]:
        """Products of powers of all rows, with signs that are right, and how many they count as."""
        if not self.rows:
            return self.products, self.count
        powers, n = np.array([row.powers for row in self.rows]), len(self.rows)
        kept = BLOCK_FORGETTING_FACTOR ** np.arange(n - 1, -1, -1)
        products = BLOCK_FORGETTING_FACTOR**n * self.products + (kept * powers.T) @ powers
        return products, float(BLOCK_FORGETTING_FACTOR**n * self.count + kept.sum())

    def _without_first(self) -> TurnedSigns:
        first, *rows = self.rows
        forces = np.vstack([first.take, first.give.sum(axis=0)]).T  # (f, 3)
        return replace(
            self,
            rows=tuple(rows),
            products=BLOCK_FORGETTING_FACTOR * self.products + np.outer(first.powers, first.powers),
            forces=BLOCK_FORGETTING_FACTOR * self.forces + forces[:, :, None] * forces[:, None],
            count=BLOCK_FORGETTING_FACTOR * self.count + 1.0,
        )

    def judged(self) -> TurnedSigns:
        """With the signs of the likeliest explanation, if it is sure enough."""
        if self.count < MIN_EVIDENCE_ROWS:
            return self
        if PowerBalance.of(self.products).left(1.0, self.count) > MAX_UNEXPLAINED_FRACTION:
            return self
        last = self._last
        if last.most_gained < LEAST_GAINED:
            return self
        turns = _turns(len(self.signs))
        logs, begins = last.log_likelihoods(turns)
        odds = np.array([*[COMMON_MOUNTING_ODDS] * len(turns), 1.0, 1.0])
        told = probabilities(logs, odds)[: len(turns)]
        if told.max() >= REFUSAL_PROBABILITY:  # seldom, and a push takes long to look for
            told = probabilities(np.append(logs, last.with_force()), np.append(odds, 1.0))[: len(turns)]
        if not told.max() >= REFUSAL_PROBABILITY:
            return self
        best = int(told.argmax())
        signs, begin = turns[best], int(begins[best])
        rows = (*self.rows[:begin], *[row.turned(signs) for row in self.rows[begin:]])
        return replace(self, rows=rows, signs=signs * self.signs, probability=float(told[best]))

    @property
    def _last(self) -> _LastRows:
        """The last rows beside what those before taught."""
        own, given = self.forces[:, :2, :2] + TINY * np.eye(2), self.forces[:, :2, 2]
        inverse = np.linalg.inv(own)
        shares = np.maximum((inverse @ given[..., None])[..., 0], 0.0)
        usual = np.einsum("fi,fij,fj->f", shares, own, shares) / self.count
        off = usual + (self.forces[:, 2, 2] - 2.0 * (shares * given).sum(axis=1)) / self.count
        off = np.maximum(off, 0.0)[:, None]
        take = np.array([row.take for row in self.rows]).transpose(2, 1, 0)  # (f, 2, n)
        needed = (shares[:, None] @ take)[:, 0]
        independent = max(self.count / ROWS_PER_INDEPENDENT_ROW - 2.0, 1.0)
        unsure = off * self.count / independent * (take * (inverse @ take)).sum(axis=1)
        variance = UNEXPLAINED_FRACTION**2 * (usual[:, None] + needed**2) + off + SHARED_ERROR_ROWS * unsure
        give = np.array([row.give for row in self.rows]).transpose(1, 2, 0)
        return _LastRows(needed, give, variance, self.push[:, None], np.array([row.speed for row in self.rows]))


@dataclass(frozen=True)
class _LastRows:
    """Forces by the `speed` (n,) that rows need (f, n) and arms give (arms, f, n), with variances (f, n) of the errors,
    and of what else may push, (f, 1)."""

    needed: Array
    give: Array
    variance: Array
    push: Array
    speed: Array

    @property
    def left(self) -> Array:
        """What right signs leave, (f, n)."""
        return np.asarray(self.give.sum(axis=0) - self.needed)

    @property
    def most_gained(self) -> float:
        """The log-likelihood ratio of an explanation that leaves nothing to right signs."""
        left = self.left
        sound, perfect = _mixture(*self._log_densities(np.array([left, 0.0 * left])), OUTLIER_FRACTION)
        return float((perfect - sound).sum())

    def log_likelihoods(self, turns: Array) -> tuple[Array, Array]:
        """Log-likelihoods (k + 2,) of each turn (k, arms) of signs, disturbances, and no change; and the row with which
        a turn begins, (k,)."""
        left = self.left
        pair = self._log_densities(
            np.concatenate([left[None], np.einsum("ka,afn->kfn", turns, self.give) - self.needed])
        )
        sound, *others = _mixture(*pair, OUTLIER_FRACTION)
        until = np.cumsum(sound) - sound
        turned = until + _since(np.array(others))
        disturbed = until + _since(_mixture(*pair, DISTURBED_FRACTION)[0])
        likeliest = np.append(turned.max(axis=1), disturbed.max()) - math.log(RECENT_ROWS)
        return np.append(likeliest, sound.sum()), turned.argmax(axis=1)

    def _log_densities(self, left: Array) -> tuple[Array, Array]:
        """Where nothing else pushes and where something does, (..., n) each, of what is left of rows (..., f, n)."""
        pushed = self.variance + self.push * self.speed**2
        near, far = (-0.5 * (left**2 / one + np.log(one)).sum(axis=-2) for one in (self.variance, pushed))
        return near, far

    def with_force(self) -> float:
        """The log-likelihood of a constant force in the likeliest span of rows."""
        left, n, (first, last) = self.left, len(self.speed), np.triu_indices(len(self.speed))
        weights = self.speed / (ROWS_PER_INDEPENDENT_ROW * self.variance)
        known = _spans(weights * self.speed, first, last) + 1.0 / self.push
        force = _spans(weights * left, first, last) / known  # (f, spans)
        inside = (first[:, None] <= np.arange(n)) & (np.arange(n) <= last[:, None])
        pushed = force.T[..., None] * (inside * self.speed)[:, None]
        found = _mixture(*self._log_densities(left - pushed), OUTLIER_FRACTION).sum(axis=1)
        occam = -0.5 * (np.log(known * self.push) + force**2 / self.push).sum(axis=0)
        return float((found + occam).max() - 2.0 * math.log(n))


def _spans(rows: Array, first: Indices, last: Indices) -> Array:
    """Sums of rows (f, n), from each of some first to each of some last."""
    until = np.cumsum(rows, axis=1)
    return np.asarray(until[:, last] - until[:, first] + rows[:, first])


def _mixture(near: Array, far: Array, outliers: float) -> Array:
    found = np.logaddexp(math.log1p(-outliers) + near, math.log(outliers) + far)
    return np.asarray(found / ROWS_PER_INDEPENDENT_ROW)


def _since(rows: Array) -> Array:
    """Sums over each row (..., n) and those after it."""
    return np.cumsum(rows[..., ::-1], axis=-1)[..., ::-1]


def _turns(arms: int) -> Array:
    """All signs, and those of each of several arms, turned (k, arms)."""
    right = np.ones(arms)
    return np.array([-right, *(right - 2.0 * np.eye(arms) if arms > 1 else ())])
