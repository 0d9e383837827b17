"""Results as values, and as a markdown document."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from importlib.metadata import PackageNotFoundError, version

import numpy as np

from .measuring import Run

PACKAGES = (
    "numpy",
    "numba",
    "daqp",
    "quadprog",
    "piqp",
    "proxsuite",
    "osqp",
    "clarabel",
    "qpsolvers",
    "cvxpy",
    "filterpy",
    "mujoco-core",
    "rosbags",
    "pin",
)


@dataclass(frozen=True)
class Table:
    """One comparison: cells are text, the first column says who."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    load: tuple[float, float]
    rounds: int

    def markdown(self) -> str:
        lines = [f"### {self.title}", "", _row(self.columns), _row(["---"] * len(self.columns))]
        lines += [_row(row) for row in self.rows]
        begin, end = self.load
        return "\n".join([*lines, "", f"{self.rounds} rounds; load {begin:.1f} to {end:.1f}."])


@dataclass(frozen=True)
class Result:
    """What one benchmark found, with what has to be known to read it."""

    title: str
    note: str
    tables: tuple[Table, ...]

    def markdown(self) -> str:
        return "\n\n".join([f"## {self.title}", self.note, *(table.markdown() for table in self.tables)])


def timed_table(title: str, run: Run, ours: str, unit: str, extra: dict[str, dict[str, str]]) -> Table:
    """Median, p99 and the ratio of medians to `ours`; `extra` holds further columns, by their head and competitor."""
    scale = {"µs": 1e6, "ms": 1e3}[unit]
    own = run.times[ours].median
    if run.times[ours].cold:
        cold = {name: number(scale * float(np.median(times.cold))) for name, times in run.times.items()}
        extra = {f"cold, {unit}": cold} | extra
    rows = []
    for name, times in run.times.items():
        cells = (number(scale * times.median), number(scale * times.p99), f"{times.median / own:.2f}")
        rows.append((name, *cells, *(column.get(name, "") for column in extra.values())))
    columns = ("", f"median, {unit}", f"p99, {unit}", "ratio", *extra)
    return Table(title, columns, tuple(rows), run.load, run.rounds)


def document(results: Sequence[Result], command: str, missing: Sequence[str]) -> str:
    head = [
        f"# Benchmarks, {date.today().isoformat()}",
        f"Written by `{command}` on {date.today().isoformat()}, with {_versions()}.",
        "Competitors take turns within one run on a machine that does other work too: read the ratios, which are of "
        "medians, to the first row; p99 is mostly the machine's. Where calls are short a turn is a burst of calls, and "
        "`cold` is the median of its first call, right after the others have emptied the caches. Load is the mean of "
        "the last minute. Matrices are tiny: BLAS has one thread if `OMP_NUM_THREADS=1` is set, as `make bench` does.",
    ]
    if missing:
        head.append(f"Left out, because not installed: {', '.join(missing)}.")
    return "\n\n".join([*head, *(result.markdown() for result in results)]) + "\n"


def number(value: float) -> str:
    """Three significant digits, without an exponent."""
    digits = 0 if value >= 100 else 1 if value >= 10 else 2
    return f"{value:,.{digits}f}"


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _versions() -> str:
    found = [f"Python {platform.python_version()}"]
    for package in PACKAGES:
        try:
            found.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            continue
    return ", ".join(found)
