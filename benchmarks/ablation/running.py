"""Diagnoses of logs with one constant at another value, in processes that go on where they were interrupted.

What came of a log is kept as JSON under a digest of the code, the constant, its value and the log.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from cartgrasp.strict_json import finite
from cartgrasp.studies.campaigns.job import FAILURES, code_version
from cartgrasp.writing import write_atomically
from estimation.discrepancy import diagnose

from ..measured.running import KEPT
from .cases import Case
from .constants import OFF, Constant
from .patching import patched


@dataclass(frozen=True)
class Job:
    """A case with a constant moved; None as it is."""

    case: Case
    constant: Constant | None = None
    move: str = ""

    @property
    def value(self) -> Any:
        return None if self.constant is None else self.constant.moved(self.move)

    @property
    def place(self) -> tuple[str, str, str]:
        """By which an answer is found."""
        return _place(self.constant, self.move, self.case)

    def digest(self) -> str:
        name = "" if self.constant is None else f"{self.constant.module}.{self.constant.name} = {self.value!r}"
        whole = hashlib.sha256(f"{code_version()} {self.case.name} {name}\0".encode())
        for path in self.case.files:
            whole.update(path.read_bytes())
        return whole.hexdigest()[:24]


@dataclass(frozen=True)
class Answer:
    """What a diagnosis says, and a digest of all that it says, scores of all candidates included; or why there is none;
    with the seconds that it took."""

    report: Mapping[str, Any] | None
    digest: str
    failure: str
    seconds: float


Answers = dict[tuple[str, str, str], Answer]
"""By constant, move and case."""


def run_all(jobs: Sequence[Job], kept: Path, processes: int) -> Iterator[tuple[Job, Answer]]:
    """As they come."""
    from joblib import Parallel, delayed

    work = Parallel(processes, return_as="generator_unordered", batch_size=1)
    yield from work(delayed(run)(job, kept) for job in jobs)


def run(job: Job, kept: Path) -> tuple[Job, Answer]:
    """From what is kept, where it is."""
    path = kept / f"{job.digest()}.json"
    if path.is_file():
        document = json.loads(path.read_text(encoding="utf-8"))
        return job, Answer(**{key: document[key] for key in ("report", "digest", "failure", "seconds")})
    answer = _diagnosed(job)
    constant, move, case = job.place
    kept.mkdir(parents=True, exist_ok=True)
    document = {"case": case, "constant": constant, "move": move, **asdict(answer)}
    write_atomically(path, json.dumps(finite(document), indent=1, allow_nan=False) + "\n")
    return job, answer


def _diagnosed(job: Job) -> Answer:
    start = perf_counter()
    moved = nullcontext() if job.constant is None else patched(job.constant, job.value)
    try:
        with moved, np.errstate(all="ignore"):
            report = finite(diagnose(*job.case.read()).report.as_dict())
    except FAILURES as error:
        return Answer(None, "", str(error) or type(error).__name__, perf_counter() - start)
    whole = hashlib.sha256(json.dumps(report, sort_keys=True).encode()).hexdigest()[:24]
    return Answer({key: report[key] for key in KEPT if key in report}, whole, "", perf_counter() - start)


def wanted(cases: Sequence[Case], constants: Sequence[Constant], moves: Sequence[str]) -> Iterator[Job]:
    """Every case with every constant at every value that it can have."""
    for constant in constants:
        for move in moves:
            if constant.moved(move) is not None:
                yield from (Job(case, constant, move) for case in cases)


def is_between(constant: Constant, move: str) -> bool:
    """Whether a value lies between the present one and the one that switches the rule off."""
    value, off = constant.value, constant.off
    if move == OFF or not isinstance(off, int | float) or not isinstance(value, int | float):
        return False
    return bool(min(value, off) <= constant.moved(move) <= max(value, off))


def foretold(job: Job, answers: Answers) -> Answer | None:
    """What is said of a log on which a bound is switched off without any change, at a value in between: the same."""
    base, off = answers[_place(None, "", job.case)], answers.get(_place(job.constant, OFF, job.case))
    if off is None or not base.digest or off.digest != base.digest or not is_between(job.constant, job.move):
        return None
    return base


def _place(constant: Constant | None, move: str, case: Case) -> tuple[str, str, str]:
    return "" if constant is None else constant.full_name, move, f"{case.kind}: {case.name}"
