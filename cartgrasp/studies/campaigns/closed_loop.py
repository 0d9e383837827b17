"""Closed-loop runs of drawn carts: one scenario, many seeds."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...simulation.record import RunRecord
from ..run_figures import RunFigures
from ..scenario import Scenario
from .drawing import Drawn, drawn_values, with_values
from .job import Job

SERIES_INTERVAL = 1.0
"""s between what is kept of estimates and tracking error."""


@dataclass(frozen=True)
class ClosedLoopStudy:
    """`scenario` but for its seed and the `drawn` parameters of its truth; `told` is both as the file has them."""

    name: str
    scenario: Scenario
    drawn: tuple[Drawn, ...]
    seed: int
    runs: int
    told: dict[str, Any] = field(repr=False)

    def jobs(self) -> list[ClosedLoopRun]:
        return [ClosedLoopRun(self, run) for run in range(self.runs)]


@dataclass(frozen=True)
class ClosedLoopRun(Job):
    """Number `run` of a study."""

    study: ClosedLoopStudy
    run_number: int

    @property
    def config(self) -> dict[str, Any]:
        return self.study.told

    @property
    def seed(self) -> list[int]:
        return [self.study.seed, self.run_number]

    @property
    def drawn(self) -> dict[str, float]:
        """The parameters of this run's truth that are drawn."""
        return drawn_values(self.study.drawn, self.study.scenario.truth, np.random.default_rng(self.seed))

    @property
    def scenario(self) -> Scenario:
        """The run, ready."""
        scenario, noise = self.study.scenario, np.random.SeedSequence([*self.seed, 1]).generate_state(1, np.uint64)
        return replace(scenario, truth=with_values(scenario.truth, self.drawn), seed=int(noise[0]))

    def run(self) -> dict[str, Any]:
        from ..compiled_loop.loop import compiled_run, covers

        scenario = self.scenario
        record = compiled_run(scenario) if covers(scenario) else scenario.run()
        return {"drawn": self.drawn, **RunFigures.of(record).as_dict(), "series": _series(record)}


def _series(record: RunRecord) -> dict[str, Any]:
    """Values at multiples of SERIES_INTERVAL."""
    time = record.time
    rows = np.searchsorted(time, np.arange(time[0], time[-1] + 1e-9, SERIES_INTERVAL) - 1e-9)
    parameters = {
        name: {"value": one.value[rows].tolist(), "std": one.std[rows].tolist()}
        for name, one in record.parameters.items()
    }
    return {
        "time": time[rows].tolist(),
        "tracking_error": record.tracking_error[rows].tolist(),
        "parameters": parameters,
    }
