"""How far a row of the regression is worked out: fast loops go on by one stage, or a part of it, with each sample.

Begun (moments are smoothed) -> Block -> RowOf -> TakenIn -> Heard -> Decided; in a trial RowOf -> Tried -> TakenIn,
and where a row has one begin Heard -> Beginning -> Decided.
"""

from __future__ import annotations

from typing import NamedTuple

from ..kernels.row_algebra import FilteredRow, Weights
from .filtered_row import Block
from .motion_tracker import Smoothing
from .regression_belief import Innovation
from .trial import Beginning, Trial, TrialRow
from .wrench_loudness import WrenchLoudness


class Begun(NamedTuple):
    """A block of `end` moments, of which the next one has not the first k, while they are smoothed."""

    k: int
    end: int
    weights: Weights
    smoothing: Smoothing


class RowOf(NamedTuple):
    """The row of a block that ends at a time (s), and `Weights.of_white`."""

    time: float
    row: FilteredRow
    of_white: float


class Tried(NamedTuple):
    """A row of a time (s) on its way through a trial."""

    time: float
    row: TrialRow

    def go_on(self) -> Tried | TakenIn:
        row = self.row.go_on()
        return self._replace(row=row) if row.trial is None else TakenIn(self.time, row.trial)


class TakenIn(NamedTuple):
    """A row of a time (s) that the belief has taken in: its innovation, or the trial that went on with it."""

    time: float
    told: Innovation | Trial

    def heard(self, before: WrenchLoudness) -> tuple[WrenchLoudness, Heard]:
        """How loud wrenches are after the row."""
        innovation = self.told.innovation if isinstance(self.told, Trial) else self.told
        return before.after(innovation), Heard(self.time, self.told)


class Heard(NamedTuple):
    """What a row of a time (s) told, after which it is known how loud wrenches are."""

    time: float
    told: Innovation | Trial


class Decided(NamedTuple):
    """A row after which it is known what to believe."""


Unfinished = Begun | Block | RowOf | Tried | TakenIn | Heard | Beginning | Decided
