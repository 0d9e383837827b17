"""A run in a few numbers: what it achieved."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..frames import Array
from ..simulation.record import RunRecord, Series

TRACKING_SETTLING_TIME = 5.0


@dataclass(frozen=True)
class RunFigures:
    """Tracking error in m; for each parameter its truth (None where unknown), last value, sd, and unit; the
    last `health` of the estimate, "" where nothing was estimated."""

    duration: float
    largest_error: float
    rms_error: float
    error_after_5: float
    plans: int
    optimal: int
    regrasps: int
    largest_force: float
    parameters: dict[str, dict[str, Any]]
    health: str = ""

    @classmethod
    def of(cls, record: RunRecord) -> RunFigures:
        error = record.tracking_error
        late = error[record.time >= TRACKING_SETTLING_TIME]
        contacts = [arm.contact for arm in record.log.arms.values()]
        forces = [np.linalg.norm(w[:, :3], axis=1).max() for w in record.wrenches.values()]
        return cls(
            duration=float(record.time[-1]),
            largest_error=float(error.max()),
            rms_error=float(np.sqrt((error**2).mean())),
            error_after_5=float(late.max()) if len(late) else float("nan"),
            plans=len(record.statuses),
            optimal=sum(status == "optimal" for status in record.statuses),
            regrasps=sum(_regrasps(contact) for contact in contacts),
            largest_force=float(max(forces)),
            parameters={name: _parameter(record, name, series) for name, series in record.parameters.items()},
            health=record.healths[-1] if record.healths else "",
        )

    def as_dict(self) -> dict[str, Any]:
        return dict(vars(self))


def _regrasps(contact: Array) -> int:
    """How often a hand's place (n, 3) begins to change."""
    moves = np.abs(np.diff(contact, axis=0)).max(axis=1) > 1e-9
    return int(moves[:1].sum() + (moves[1:] & ~moves[:-1]).sum())


def _parameter(record: RunRecord, name: str, series: Series) -> dict[str, Any]:
    return {
        "truth": None if series.truth is None else float(series.truth[-1]),
        "value": float(series.value[-1]),
        "std": float(series.std[-1]),
        "unit": series.unit,
        "identifiable": bool(record.identifiable.get(name, False)),
    }
