"""How much later a log's wrenches are than its motion, as the rows of a fitted model say.

A model's rows have a column of what a lateness does to them. How late wrenches are is beforehand known to a share of a
sample's step. What is told here is what the rows alone say, with that taken out again.
"""

from __future__ import annotations

from dataclasses import dataclass

from .search.model import Model

MAX_OFFSET_STD = 0.05
"""Largest standard deviation (s) of an offset: whoever does not know it better knows nothing."""


@dataclass(frozen=True)
class ClockOffset:
    """How much later wrenches are than the motion (s), and its standard deviation."""

    value: float
    std: float


def clock_offsets(model: Model) -> tuple[ClockOffset | None, ...]:
    """Clock offset of each log; None without arms, or where nothing tells."""
    first = len(model.prior_std) - len(model.logs)
    return tuple(_of_rows_alone(model, first + i) for i in range(len(model.logs)))


def _of_rows_alone(model: Model, column: int) -> ClockOffset | None:
    """The posterior's mean and variance are those of rows and prior, weighed by information."""
    prior = float(model.prior_std[column]) ** -2
    variance, value = float(model.score.covariance[column, column]), float(model.score.fit[column])
    information = 1 / variance - prior
    if information < MAX_OFFSET_STD**-2:
        return None
    return ClockOffset(model.wrench_delay + value / (variance * information), information**-0.5)
