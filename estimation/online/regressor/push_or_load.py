"""Whether what surprises is a push or a load: both are believed until rows tell.

A load changes the parameters from some moment on, a push nothing but the rows in which it acts. So from the first row
that surprised there are two beliefs, one that is opened to a load and takes in all rows, and one that leaves out rows
which a push would make more likely. Each row's likelihood under either moves the odds (Bayes), and what is told
meanwhile is their mixture, whose deviation holds both.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array

from ..kernels.filtered_row import FilteredRow
from .regression_belief import RegressionBelief, Surprise, mixture

DECIDED = math.log(1000.0)
"""Of the odds, beyond which one of the two is left."""
LEAST, LONGEST = 15, 60
"""Blocks before which no load is told for sure, since a push may last so long; and rows after which what is still not
told apart is one belief, as wide as both."""
SETTING_IN = 2
"""Rows that tell nothing of a load, since it may be put on within them: a row is of means over 0.1 s."""
OVER = 5
"""Rows in a row without a push after which it is over."""
STEADY = 0.25
"""Of a push's usual size, by how much it changes from row to row."""


class Taken(NamedTuple):
    """A row worked out around parameters (p,), and what was believed before it."""

    before: RegressionBelief
    row: FilteredRow
    at: Array


class Pushed(NamedTuple):
    """What is believed if there is nothing but a push: of a force (n,) in the last row in which it acted, `rows` ago;
    and by how much it is likelier than nothing in all of them (a logarithm)."""

    belief: RegressionBelief
    force: Array
    rows: int = 1
    evidence: float = 0.0

    def and_then(self, row: FilteredRow, at: Array, usual: Array) -> tuple[Pushed, float, Surprise]:
        """With a row, and its log-likelihood. Of one in which a push is likelier nothing is learned."""
        belief, gain = self.belief.copy(), 1.0 - row.fade
        surprise = belief.absorb(row, at)
        mean, covariance = (self.force, STEADY**2 * usual) if self.rows == 0 else (np.zeros(len(usual)), usual)
        without, beside = surprise.log_likelihood(), surprise.log_likelihood(gain * mean, gain**2 * covariance)
        if without >= beside:
            return self._replace(belief=belief, rows=self.rows + 1), without, surprise
        belief = self.belief.copy()
        belief.unlink()
        gained = self.evidence + beside - without
        return Pushed(belief, surprise.news / gain, 0, gained), beside, surprise


@dataclass(frozen=True)
class PushOrLoad:
    """Both beliefs, the surprise of the last row under the likelier of them, and the logarithm of the odds of a load;
    how many rows there were, blocks in which the cart stood still, and blocks without a row for whatever reason.
    `usual` (n, n) is the covariance of usual pushes."""

    pushed: Pushed
    loaded: RegressionBelief
    usual: Array
    surprise: Surprise
    odds: float = 0.0
    rows: int = 0
    still: int = 0
    without: int = 0

    @classmethod
    def since(cls, taken: Sequence[Taken], load: Array, usual: Array) -> PushOrLoad:
        """From the first of the last rows in which a push is likely on, for a load of covariance (f, f)."""
        pushed, left = Pushed(taken[0].before.copy(), np.zeros(len(usual))), list(taken)
        while True:
            following, _, surprise = pushed.and_then(left[0].row, left[0].at, usual)
            if following.rows == 0 or len(left) == 1:
                break
            pushed, left = following, left[1:]
        loaded = pushed.belief.copy()
        loaded.open(load)
        found = cls(pushed, loaded, usual, surprise)
        for one in left:
            found = found.and_then(one.row, one.at)
        return found

    def and_then(self, row: FilteredRow, at: Array) -> PushOrLoad:
        """With one row more."""
        pushed, of_push, by_push = self.pushed.and_then(row, at, self.usual)
        loaded, rows = self.loaded.copy(), self.rows + 1
        if rows <= SETTING_IN:
            loaded.unlink()
            return replace(self, pushed=pushed, loaded=loaded, rows=rows, surprise=by_push)
        by_load = loaded.absorb(row, at)
        odds = self.odds + by_load.log_likelihood() - of_push
        said = by_load if odds > 0.0 else by_push
        return replace(self, pushed=pushed, loaded=loaded, odds=odds, rows=rows, surprise=said)

    def unlinked(self, *, is_still: bool) -> PushOrLoad:
        """With a block that brought no row, since the cart stood still or for another reason."""
        pushed, loaded = self.pushed.belief.copy(), self.loaded.copy()
        pushed.unlink()
        loaded.unlink()
        return replace(
            self,
            pushed=self.pushed._replace(belief=pushed),
            loaded=loaded,
            still=self.still + is_still,
            without=self.without + 1,
        )

    @property
    def is_over(self) -> bool:
        is_quiet = self.pushed.rows >= OVER or self.still >= LEAST
        told = self.rows + self.still >= LEAST if self.odds > 0.0 else is_quiet
        return (told and abs(self.odds) > DECIDED) or self.rows >= LONGEST

    @property
    def is_loaded(self) -> bool:
        """Surely."""
        return self.odds > DECIDED

    @property
    def is_pushed(self) -> bool:
        """In the last row."""
        return self.pushed.rows == 0

    @property
    def has_push(self) -> bool:
        """Surely."""
        return self.pushed.evidence > DECIDED

    @property
    def is_told(self) -> bool:
        """Whether a load is, or a push that is not long gone, if only as long as nothing else comes."""
        return self.is_loaded or (self.has_push and self.without < LEAST)

    @property
    def is_endless(self) -> bool:
        """What pushes for so long is no push, but the model's error: neither belief is right."""
        return self.rows >= LONGEST and self.odds < -DECIDED and self.pushed.rows < OVER

    @property
    def belief(self) -> RegressionBelief:
        """What is left of the two, or both as one; another each time, which may be changed."""
        if self.is_endless:
            return mixture(self.pushed.belief, self.loaded, 0.5)
        if self.is_loaded:
            return self.loaded.copy()
        if self.odds < -DECIDED:
            return self.pushed.belief.copy()
        return mixture(self.pushed.belief, self.loaded, 1.0 / (1.0 + math.exp(-self.odds)))
