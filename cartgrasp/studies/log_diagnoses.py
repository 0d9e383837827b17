"""The discrepancy workflow on many logs: FOLDER/logs/NAME holds `run.csv` (or `.parquet`, `.mcap`) and `cart.yaml`,
and gets `out`.

What has its report is left alone, so a study that was killed goes on where it was.
"""

from __future__ import annotations

import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from estimation.discrepancy import diagnose

from ..cart_file import load_cart
from ..errors import CartgraspError, UsageError
from ..logs import read_log
from ..writing import write_atomically
from .findings import Claim
from .parallel import Progress, run_all

COLUMNS = ("log", "verdict", "effects", "s")
LOGS = ("run.csv", "run.parquet", "run.mcap")
REPORT, SECONDS = "report.json", "seconds.json"


@dataclass(frozen=True)
class LogDiagnosis:
    """What came of one log; `seconds` that its diagnosis took (None: not known), `failure` where there is none."""

    name: str
    verdict: str = ""
    effects: tuple[str, ...] = ()
    seconds: float | None = None
    failure: str = ""

    @property
    def cells(self) -> tuple[str, str, str, str]:
        """By COLUMNS."""
        seconds = "" if self.seconds is None else f"{self.seconds:.1f}"
        return self.name, self.verdict or "failed", self.failure or ", ".join(self.effects) or "-", seconds

    def as_dict(self) -> dict[str, Any]:
        return asdict(self)


def log_folders(folder: Path) -> list[Path]:
    found = sorted({path.parent for name in LOGS for path in folder.glob(f"logs/*/{name}")})
    if not found:
        raise UsageError(
            f"{folder}: there is no logs/NAME/run.csv, .parquet or .mcap; put each log and its cart.yaml into such a "
            "folder"
        )
    return found


def _log_of(folder: Path) -> Path:
    there = [path for path in (folder / name for name in LOGS) if path.is_file()]
    if len(there) > 1:
        raise UsageError(f"{folder}: holds {' and '.join(path.name for path in there)}; leave one of them")
    return there[0]


def diagnose_all(folder: Path, workers: int = 1, progress: Progress = None) -> list[LogDiagnosis]:
    return run_all(diagnose_one, log_folders(folder), workers, progress)


def diagnose_one(folder: Path) -> LogDiagnosis:
    """The report is the last that is written: where it is, all is."""
    out = folder / "out"
    try:
        if not (out / REPORT).is_file():
            start = time.perf_counter()
            found = diagnose(read_log(_log_of(folder)), load_cart(folder / "cart.yaml"))
            out.mkdir(exist_ok=True)
            write_atomically(out / SECONDS, json.dumps({"seconds": time.perf_counter() - start}) + "\n")
            found.report.save(out)
        return saved(folder)
    except (CartgraspError, ArithmeticError, ValueError, OSError) as error:  # a finding, not the end of the study
        return LogDiagnosis(folder.name, failure=str(error) or type(error).__name__)


def saved(folder: Path) -> LogDiagnosis:
    """What is told in a folder's report."""
    out = folder / "out"
    report = json.loads((out / REPORT).read_text(encoding="utf-8"))
    taken = out / SECONDS
    seconds = json.loads(taken.read_text(encoding="utf-8"))["seconds"] if taken.is_file() else None
    effects = tuple(f"{e['name']} {e['label']}".strip() for e in report["effects"])
    return LogDiagnosis(folder.name, report["verdict"], effects, seconds)


def claims(found: list[LogDiagnosis]) -> list[Claim]:
    done = sum(not one.failure for one in found)
    return [Claim("all logs", "each log is read and diagnosed", f"{done} of {len(found)}", done == len(found))]
