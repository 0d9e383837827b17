"""A log run through an online estimator, as if it were happening."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from cartgrasp.logs import RunLog
from cartgrasp.motion import Estimate
from cartgrasp.roles import Estimator


@dataclass(frozen=True)
class Replay:
    """The estimates (n,), one a row of the log."""

    estimates: tuple[Estimate, ...]

    @property
    def last(self) -> Estimate:
        return self.estimates[-1]

    def as_dict(self) -> dict[str, Any]:
        """The result as the command line gives it."""
        parameters = {
            name: {"value": p.value, "std": p.std, "unit": p.unit, "identifiable": p.identifiable}
            for name, p in self.last.parameters.items()
        }
        return {"time": self.last.time, "parameters": parameters, "health": str(self.last.health)}

    def series_csv(self) -> str:
        """Time, and value and standard deviation of each parameter."""
        names = list(self.last.parameters)
        header = ["t", *(f"{name}{suffix}" for name in names for suffix in ("", ".std")), "health"]
        lines = [",".join(header)]
        for estimate in self.estimates:
            cells = [repr(estimate.time)]
            for name in names:
                parameter = estimate.parameters[name]
                cells += [_cell(parameter.value), _cell(parameter.std)]
            lines.append(",".join([*cells, str(estimate.health)]))
        return "\n".join(lines) + "\n"


def replay(log: RunLog, estimator: Estimator, progress: Callable[[float], None] | None = None) -> Replay:
    """Every row of the log in turn; `progress` is told the share done."""
    estimates = []
    for i, measurement in enumerate(log.measurements()):
        estimates.append(estimator.update(measurement))
        if progress is not None and i % 100 == 0:
            progress(i / len(log))
    return Replay(tuple(estimates))


def _cell(value: float) -> str:
    return repr(value) if math.isfinite(value) else ""
