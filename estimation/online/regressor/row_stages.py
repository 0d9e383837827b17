"""How far a row of the regression is worked out: fast loops go on by one stage, or a part of it, with each sample.

A stage holds what a row has come to by now; `ParameterLearner._go_on` says what is done with each next.

SmoothingStage -> Block -> AskedRow -> RowStage -> TakenInStage -> UndecidedStage -> DoneStage. While load hypotheses
are open, a HypothesesStage is between RowStage and TakenInStage. Where a row opens them, a HypothesesOpening is between
UndecidedStage and DoneStage, and a slice of it is one belief more, or one row more.
"""

from __future__ import annotations

from typing import NamedTuple

from ..kernels.row_algebra import FilteredRow, Weights
from .filtered_row import AskedRow, Block
from .load_hypotheses import HypothesesOpening, HypothesesUpdate, LoadHypotheses
from .motion_tracker import Smoothing
from .regression_belief import Innovation
from .wrench_noise_scale import WrenchNoiseScale


class SmoothingStage(NamedTuple):
    """A block of `end` moments, of which the next one has not the first k, while they are smoothed."""

    k: int
    end: int
    weights: Weights
    smoothing: Smoothing


class RowStage(NamedTuple):
    """The row of a block that ends at a time (s), and `Weights.of_white`."""

    time: float
    row: FilteredRow
    of_white: float


class HypothesesStage(NamedTuple):
    """A row of a time (s) on its way through load hypotheses: some of their beliefs have taken it in."""

    time: float
    update: HypothesesUpdate

    def go_on(self) -> HypothesesStage | TakenInStage:
        update = self.update.go_on()
        if update.hypotheses is None:
            return self._replace(update=update)
        return TakenInStage(self.time, update.hypotheses)


class TakenInStage(NamedTuple):
    """A row of a time (s) that the belief has taken in: its innovation, or the load hypotheses that went on with
    it."""

    time: float
    told: Innovation | LoadHypotheses

    def with_noise_scale(self, before: WrenchNoiseScale) -> tuple[WrenchNoiseScale, UndecidedStage]:
        """The noise scale of wrenches after the row."""
        innovation = self.told.innovation if isinstance(self.told, LoadHypotheses) else self.told
        return before.after(innovation), UndecidedStage(self.time, self.told)


class UndecidedStage(NamedTuple):
    """What a row of a time (s) told, after which the noise scale of wrenches is known, but nothing of loads."""

    time: float
    told: Innovation | LoadHypotheses


class DoneStage(NamedTuple):
    """A row after which it is known what to believe, and the parameters follow: `RowLearning.conclude`."""


Stage = (
    SmoothingStage
    | Block
    | AskedRow
    | RowStage
    | HypothesesStage
    | TakenInStage
    | UndecidedStage
    | HypothesesOpening
    | DoneStage
)
