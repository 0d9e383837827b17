"""How far a row of the regression is worked out: fast loops go on by one stage, or a part of it, with each sample.

SmoothingStage -> Block -> AskedRow -> RowStage -> UpdateStage -> NoiseScaleStage -> DoneStage; while load hypotheses
are open RowStage -> HypothesisStage -> UpdateStage, and where a row opens them NoiseScaleStage -> HypothesesStart ->
DoneStage.
"""

from __future__ import annotations

from typing import NamedTuple

from ..kernels.row_algebra import FilteredRow, Weights
from .filtered_row import AskedRow, Block
from .load_hypotheses import HypothesesStart, HypothesesUpdate, LoadHypotheses
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


class HypothesisStage(NamedTuple):
    """A row of a time (s) on its way through load hypotheses."""

    time: float
    row: HypothesesUpdate

    def go_on(self) -> HypothesisStage | UpdateStage:
        row = self.row.go_on()
        return self._replace(row=row) if row.hypotheses is None else UpdateStage(self.time, row.hypotheses)


class UpdateStage(NamedTuple):
    """A row of a time (s) that the belief has taken in: its innovation, or the load hypotheses that went on with
    it."""

    time: float
    told: Innovation | LoadHypotheses

    def with_noise_scale(self, before: WrenchNoiseScale) -> tuple[WrenchNoiseScale, NoiseScaleStage]:
        """The noise scale of wrenches after the row."""
        innovation = self.told.innovation if isinstance(self.told, LoadHypotheses) else self.told
        return before.after(innovation), NoiseScaleStage(self.time, self.told)


class NoiseScaleStage(NamedTuple):
    """What a row of a time (s) told, after which the noise scale of wrenches is known."""

    time: float
    told: Innovation | LoadHypotheses


class DoneStage(NamedTuple):
    """A row after which it is known what to believe."""


Stage = (
    SmoothingStage
    | Block
    | AskedRow
    | RowStage
    | HypothesisStage
    | UpdateStage
    | NoiseScaleStage
    | HypothesesStart
    | DoneStage
)
