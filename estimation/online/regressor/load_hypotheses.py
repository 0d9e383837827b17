"""Whether what surprises is a push, a load or another floor: all are believed until rows tell.

A load changes the body from some moment on, another floor what goes with the weight (resistance, slope), a push nothing
but the rows in which it acts. So from the first row that surprised there are several beliefs: one that leaves out rows
which a push would make more likely, and one for each change, opened to it, that takes in all rows. Each row's
likelihood under them moves their odds (Bayes). What is told meanwhile has no load, and is as unsure as all of them are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array

from ..kernels.row_algebra import FilteredRow
from .regression_belief import Innovation, RegressionBelief, Unlinked, mixture

DECISION_NATS = math.log(1000.0)
"""The log odds beyond which only one of the beliefs is left."""
MIN_HYPOTHESES_BLOCKS, MAX_HYPOTHESES_ROWS = 15, 60
"""Blocks before which hypotheses stay open, since a push may last so long; and rows after which what is still not told
apart is one belief, as wide as both."""
CHANGE_ONSET_ROWS = 2
"""Rows that tell nothing of a change, since it may set in within them: a row is of means over 0.1 s."""
PUSH_END_ROWS = 5
"""Rows in a row without a push after which it is over."""
PUSH_STEP_STD_RATIO = 0.25
"""Standard deviation of a push's change from row to row, as a share of its usual size."""


class LearnedRow(NamedTuple):
    """A row worked out around parameters (p,), and what was believed before it."""

    before: RegressionBelief
    row: FilteredRow
    at: Array


class PushHypothesis(NamedTuple):
    """What is believed if there is nothing but a push: of a force (n,) in the last row in which it acted, `rows` ago;
    and by how much it is likelier than nothing in all of them (a logarithm)."""

    belief: RegressionBelief
    force: Array
    rows: int = 1
    evidence: float = 0.0

    def and_then(self, row: FilteredRow, at: Array, usual: Array) -> tuple[PushHypothesis, float, Innovation]:
        """The belief after a row, the row's log-likelihood, and its innovation. Nothing is learned from a row in which
        a push is likelier."""
        belief, gain = self.belief.copy(), 1.0 - row.fade
        innovation = belief.update(row, at)
        mean, covariance = (
            (self.force, PUSH_STEP_STD_RATIO**2 * usual) if self.rows == 0 else (np.zeros(len(usual)), usual)
        )
        without = innovation.quasi_log_likelihood()
        beside = innovation.quasi_log_likelihood(gain * mean, gain**2 * covariance)
        if without >= beside:
            return self._replace(belief=belief, rows=self.rows + 1), without, innovation
        belief = self.belief.copy()
        belief.drop_link()
        gained = self.evidence + beside - without
        return PushHypothesis(belief, innovation.in_own[0] / gain, 0, gained), beside, innovation


class ChangeHypothesis(NamedTuple):
    """What is believed if the load, or the floor, is another; and the logarithm of its odds against a push."""

    belief: RegressionBelief
    is_load: bool
    odds: float = 0.0

    def and_then(self, row: FilteredRow, at: Array, of_push: float) -> tuple[ChangeHypothesis, Innovation]:
        """The belief after a row, which has the log-likelihood `of_push` under a push, and the row's innovation."""
        belief = self.belief.copy()
        innovation = belief.update(row, at)
        return self._replace(belief=belief, odds=self.odds + innovation.quasi_log_likelihood() - of_push), innovation

    def without_link(self) -> ChangeHypothesis:
        """The belief after a row that tells nothing of the change."""
        belief = self.belief.copy()
        belief.drop_link()
        return self._replace(belief=belief)


# Many methods: questions to the same few probabilities, of three lines each, as its callers ask them.
@dataclass(frozen=True)
class LoadHypotheses:
    """All beliefs since a `time` (s), and the innovation of the last row under the likeliest; how many rows there were,
    blocks in which the cart stood still, and blocks without a row for whatever reason. `usual` (n, n) is the covariance
    of usual pushes."""

    time: float
    pushed: PushHypothesis
    changed: tuple[ChangeHypothesis, ...]
    usual: Array
    innovation: Innovation
    rows: int = 0
    still: int = 0
    without: int = 0

    def with_row(self, row: FilteredRow, at: Array) -> HypothesesUpdate:
        """The way to these hypotheses after one more row."""
        return HypothesesUpdate(self, row, at)

    def without_link(self, *, is_still: bool) -> LoadHypotheses:
        """The hypotheses after a block that brought no row, since the cart stood still or for another reason."""
        pushed = self.pushed.belief.copy()
        pushed.drop_link()
        return replace(
            self,
            pushed=self.pushed._replace(belief=pushed),
            changed=tuple(one.without_link() for one in self.changed),
            still=self.still + is_still,
            without=self.without + 1,
        )

    @cached_property
    def _odds(self) -> Array:
        """Logarithms (1 + c,) of a push and of the changes, against a push."""
        return np.array([0.0, *(one.odds for one in self.changed)])

    @cached_property
    def _shares(self) -> Array:
        """The probabilities of the beliefs (1 + c,)."""
        odds = self._odds
        return np.asarray(np.exp(odds - np.logaddexp.reduce(odds)))

    @cached_property
    def _sure(self) -> int | None:
        """Which of them is left: 0 for a push; None while rows have not told."""
        odds = self._odds
        best = int(np.argmax(odds))
        return best if odds[best] - np.logaddexp.reduce(np.delete(odds, best)) > DECISION_NATS else None

    @property
    def is_over(self) -> bool:
        sure = self._sure
        if sure is None:
            return self.rows >= MAX_HYPOTHESES_ROWS
        if sure == 0:
            return (
                self.pushed.rows >= PUSH_END_ROWS
                or self.still >= MIN_HYPOTHESES_BLOCKS
                or self.rows >= MAX_HYPOTHESES_ROWS
            )
        return self.is_on_another_floor or self.rows + self.still >= MIN_HYPOTHESES_BLOCKS

    @property
    def is_loaded(self) -> bool:
        """Surely."""
        sure = self._sure
        return bool(sure and self.changed[sure - 1].is_load)

    @property
    def is_on_another_floor(self) -> bool:
        """Surely."""
        sure = self._sure
        return bool(sure and not self.changed[sure - 1].is_load)

    @property
    def is_surely_pushed(self) -> bool:
        return self._sure == 0

    @property
    def may_be_load(self) -> bool:
        """Whether that is the likeliest."""
        likeliest = int(np.argmax(self._odds))
        return likeliest > 0 and self.changed[likeliest - 1].is_load

    @property
    def is_pushed(self) -> bool:
        """Whether there was a push in the last row."""
        return self.pushed.rows == 0

    @property
    def has_push(self) -> bool:
        """Surely."""
        return self.pushed.evidence > DECISION_NATS

    @property
    def is_reported(self) -> bool:
        """Whether a load is, or a push that is not long gone, if only as long as nothing else comes."""
        return self.is_loaded or (self.has_push and self.without < MIN_HYPOTHESES_BLOCKS)

    @property
    def is_endless(self) -> bool:
        """What pushes for so long is no push, but the model's error: no belief is right."""
        return self.rows >= MAX_HYPOTHESES_ROWS and self._sure == 0 and self.pushed.rows < PUSH_END_ROWS

    @property
    def belief(self) -> RegressionBelief:
        """The one that is left, or all as one; another each time, which may be changed."""
        if self.is_endless:
            return mixture(self._unlinked, np.full(len(self._beliefs), 1.0 / len(self._beliefs)), 0)
        if self._sure is not None:
            return self._beliefs[self._sure].copy()
        return mixture(self._unlinked, self._shares, self._likeliest_unloaded)

    @property
    def not_excluded(self) -> RegressionBelief | None:
        """All beliefs that are, as one, in which they count alike: what is said to people. Rows tell apart what models
        make of them, and no model is so right. None where one is left."""
        if self._sure is not None:
            return None
        odds = self._odds
        alike = np.where(odds > odds.max() - DECISION_NATS, 1.0, 0.0)
        return mixture(self._unlinked, alike / alike.sum(), self._likeliest_unloaded)

    @property
    def if_loaded(self) -> RegressionBelief:
        """What is believed if there is another load."""
        return next(one.belief.copy() for one in self.changed if one.is_load)

    @property
    def _beliefs(self) -> list[RegressionBelief]:
        return [self.pushed.belief, *(one.belief for one in self.changed)]

    @cached_property
    def _unlinked(self) -> list[Unlinked]:
        return [Unlinked.of(one) for one in self._beliefs]

    @property
    def _likeliest_unloaded(self) -> int:
        """Which of them gives the values while all are open: the likeliest without a load."""
        loads = np.array([False, *(one.is_load for one in self.changed)])
        return int(np.argmax(np.where(loads, -1.0, self._shares)))


class HypothesesUpdate(NamedTuple):
    """A row around parameters (p,) that one belief of several takes in after the other: first the one of a push, with
    its log-likelihood and innovation, then those of changes, with theirs."""

    before: LoadHypotheses
    row: FilteredRow
    at: Array
    pushed: tuple[PushHypothesis, float, Innovation] | None = None
    changed: tuple[tuple[ChangeHypothesis, Innovation], ...] = ()

    def go_on(self) -> HypothesesUpdate:
        """With one belief more."""
        before = self.before
        if self.pushed is None:
            return self._replace(pushed=before.pushed.and_then(self.row, self.at, before.usual))
        after = before.changed[len(self.changed)].and_then(self.row, self.at, self.pushed[1])
        return self._replace(changed=(*self.changed, after))

    @property
    def hypotheses(self) -> LoadHypotheses | None:
        """The hypotheses after the row; None while a belief is left."""
        before = self.before
        if self.pushed is None:
            return None
        pushed, _, innovation = self.pushed
        if before.rows < CHANGE_ONSET_ROWS:
            changed = tuple(one.without_link() for one in before.changed)
            return replace(before, pushed=pushed, changed=changed, rows=before.rows + 1, innovation=innovation)
        if len(self.changed) < len(before.changed):
            return None
        likelier = [pair for pair in self.changed if pair[0].odds > 0.0]
        said = max(likelier, key=lambda pair: pair[0].odds)[1] if likelier else innovation
        changed = tuple(one for one, _ in self.changed)
        return replace(before, pushed=pushed, changed=changed, rows=before.rows + 1, innovation=said)


@dataclass(frozen=True)
class HypothesesOpening:
    """The way to hypotheses over the last rows, of which some are `left`: from the first in which a push is likely on
    all beliefs take them in. It was at a `time` (s) that one was needed. Loads and floors have covariances (f, f).
    There is no belief of another floor where nothing goes with the weight."""

    time: float
    pushed: PushHypothesis
    left: tuple[LearnedRow, ...]
    load: Array
    floor: Array
    usual: Array
    hypotheses: LoadHypotheses | None = None
    update: HypothesesUpdate | None = None

    @classmethod
    def of(cls, time: float, taken: Sequence[LearnedRow], load: Array, floor: Array, usual: Array) -> HypothesesOpening:
        return cls(time, PushHypothesis(taken[0].before.copy(), np.zeros(len(usual))), tuple(taken), load, floor, usual)

    def go_on(self) -> HypothesesOpening:
        """With one more row, or with one more belief after it."""
        one, *later = self.left
        if self.hypotheses is not None:
            update = (self.update or self.hypotheses.with_row(one.row, one.at)).go_on()
            if update.hypotheses is None:
                return replace(self, update=update)
            return replace(self, left=tuple(later), hypotheses=update.hypotheses, update=None)
        following, _, innovation = self.pushed.and_then(one.row, one.at, self.usual)
        if following.rows > 0 and later:
            return replace(self, pushed=following, left=tuple(later))
        changed = []
        for added, is_load in ((self.load, True), (self.floor, False)):
            if added.any():
                changed.append(ChangeHypothesis(self.pushed.belief.copy(), is_load))
                changed[-1].belief.open(added)
        return replace(self, hypotheses=LoadHypotheses(self.time, self.pushed, tuple(changed), self.usual, innovation))
