"""What all runs say together: errors, how sure the estimates were, and tracking."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

TRACKING_FIGURES = {"largest": "largest_error", "largest from 5 s on": "error_after_5", "rms": "rms_error"}
COVERAGE_SIGMAS = 2.0
PARAMETER_COLUMNS = ("parameter", "error, mean", "error, sd", "claimed sd", "in 2 sd", "taught")
TRACKING_COLUMNS = ("tracking error", "mean", "sd", "95 %", "largest")
LOG_COLUMNS = ("parameter", "logs", "mean", "sd", "claimed sd")


@dataclass(frozen=True)
class ParameterSummary:
    """Statistics of a parameter over the runs with a truth, at their ends. They are the error's mean and standard
    deviation, and the mean of the claimed standard deviations. The shares are of runs within two of these, and of those
    in which motion taught the parameter."""

    name: str
    unit: str
    runs: int
    mean_error: float
    sd_error: float
    mean_std: float
    coverage: float
    taught: float

    @classmethod
    def of(cls, name: str, found: Sequence[Mapping[str, Any]]) -> ParameterSummary:
        error = np.array([one["value"] - one["truth"] for one in found])
        std = np.array([one["std"] for one in found])
        return cls(
            name=name,
            unit=found[0]["unit"],
            runs=len(found),
            mean_error=float(error.mean()),
            sd_error=float(error.std()),
            mean_std=float(std.mean()),
            coverage=float((np.abs(error) <= COVERAGE_SIGMAS * std).mean()),
            taught=float(np.mean([one["identifiable"] for one in found])),
        )

    @property
    def cells(self) -> tuple[str, ...]:
        """The cells of a table with PARAMETER_COLUMNS."""
        numbers = (f"{value:.3g}" for value in (self.mean_error, self.sd_error, self.mean_std))
        return f"{self.name}, {self.unit}", *numbers, f"{100 * self.coverage:.1f} %", f"{100 * self.taught:.0f} %"


@dataclass(frozen=True)
class Spread:
    """Statistics of a number over the runs."""

    mean: float
    sd: float
    p95: float
    largest: float

    @classmethod
    def of(cls, values: Iterable[float | None]) -> Spread | None:
        """The statistics of the values that are there; None where there is none."""
        given = np.array([value for value in values if value is not None], dtype=float)
        if not len(given):
            return None
        return cls(float(given.mean()), float(given.std()), float(np.percentile(given, 95)), float(given.max()))


@dataclass(frozen=True)
class RunsSummary:
    """The summary of closed-loop runs. `failures` counts the messages of those that came to nothing, `healths` what
    estimates said of themselves at the end."""

    runs: int
    failures: dict[str, int]
    parameters: tuple[ParameterSummary, ...]
    tracking: dict[str, Spread]
    optimal: float
    healths: dict[str, int]

    @classmethod
    def of(cls, results: Sequence[Mapping[str, Any]]) -> RunsSummary:
        good = [one for one in results if "failure" not in one]
        spreads = {name: Spread.of(one[key] for one in good) for name, key in TRACKING_FIGURES.items()}
        return cls(
            runs=len(results),
            failures=failures(results),
            parameters=_parameters(good),
            tracking={name: spread for name, spread in spreads.items() if spread is not None},
            optimal=float(np.mean([one["optimal"] / one["plans"] for one in good])) if good else float("nan"),
            healths=dict(Counter(one["health"] for one in good if one.get("health"))),
        )

    @property
    def tracking_cells(self) -> list[tuple[str, ...]]:
        """The cells of a table with TRACKING_COLUMNS."""
        return [
            (name, *(f"{100 * value:.2f} cm" for value in (one.mean, one.sd, one.p95, one.largest)))
            for name, one in self.tracking.items()
        ]

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


@dataclass(frozen=True)
class LogsSummary:
    """The summary of logs: each parameter's values over those that have it, and what each log came to."""

    logs: tuple[dict[str, Any], ...]
    failures: dict[str, int]
    parameters: dict[str, dict[str, Any]]

    @classmethod
    def of(cls, results: Sequence[Mapping[str, Any]], names: Sequence[str]) -> LogsSummary:
        logs = tuple({"log": name, **_told(one)} for name, one in zip(names, results, strict=True))
        parameters = {
            name: {
                "unit": each[0]["unit"],
                "logs": len(each),
                "mean": float(np.mean([one["value"] for one in each])),
                "sd": float(np.std([one["value"] for one in each])),
                "mean_std": float(np.mean([one["std"] for one in each])),
            }
            for name, each in _by_name(results).items()
            if all(one["value"] is not None and one["std"] is not None for one in each)
        }
        return cls(logs, failures(results), parameters)

    @property
    def parameter_cells(self) -> list[tuple[str, ...]]:
        """The cells of a table with LOG_COLUMNS."""
        return [
            (f"{name}, {p['unit']}", str(p["logs"]), *(f"{p[key]:.4g}" for key in ("mean", "sd", "mean_std")))
            for name, p in self.parameters.items()
        ]

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


def failures(results: Sequence[Mapping[str, Any]]) -> dict[str, int]:
    """The number of failures, by their message."""
    return dict(Counter(str(one["failure"]) for one in results if "failure" in one))


def _parameters(good: Sequence[Mapping[str, Any]]) -> tuple[ParameterSummary, ...]:
    """Summaries of the parameters that are estimated and have a truth, over the runs that report both."""
    found = {
        name: [one for one in each if one["truth"] is not None and one["value"] is not None and one["std"]]
        for name, each in _by_name(good).items()
    }
    return tuple(ParameterSummary.of(name, each) for name, each in found.items() if each)


def _by_name(results: Sequence[Mapping[str, Any]]) -> dict[str, list[Mapping[str, Any]]]:
    """Each parameter as the results have it."""
    found: dict[str, list[Mapping[str, Any]]] = {}
    for one in results:
        for name, parameter in one.get("parameters", {}).items():
            found.setdefault(name, []).append(parameter)
    return found


def _told(result: Mapping[str, Any]) -> dict[str, Any]:
    if "failure" in result:
        return {"failure": result["failure"]}
    if "verdict" in result:
        return {"verdict": result["verdict"], "effects": [effect["name"] for effect in result["effects"]]}
    return {name: one["value"] for name, one in result["parameters"].items()}
