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
from .constants import Constant
from .patching import patched
from .watching import Key, noticed

Place = tuple[str, str, str]
"""Constant, move and case, by which an answer is found."""


@dataclass(frozen=True)
class Answer:
    """What a diagnosis says, and a digest of all that it says, scores of all candidates included; or why there is none;
    with the seconds that it took; and where it was watched, which values of constants it might have noticed."""

    report: Mapping[str, Any] | None
    digest: str
    failure: str
    seconds: float
    noticed: tuple[Key, ...] = ()


Answers = dict[Place, Answer]


@dataclass(frozen=True)
class Job:
    """A case with a constant moved; None as it is."""

    case: Case
    constant: Constant | None = None
    move: str = ""

    @property
    def place(self) -> Place:
        name = "" if self.constant is None else self.constant.full_name
        return name, self.move, f"{self.case.kind}: {self.case.name}"

    @property
    def setting(self) -> str:
        """What is not as it is."""
        return "" if self.constant is None else _set(self.constant, self.move)

    def ask(self) -> Answer:
        moved = nullcontext() if self.constant is None else patched(self.constant, self.constant.moved(self.move))
        with moved:
            return answered(self.case)


@dataclass(frozen=True)
class Watch:
    """A case as it is, in which it is noticed where constants would have told at other values."""

    case: Case
    constants: tuple[Constant, ...]
    moves: tuple[str, ...]

    @property
    def place(self) -> Place:
        return WATCHED, "", f"{self.case.kind}: {self.case.name}"

    @property
    def setting(self) -> str:
        known = (_set(one, move) for one in self.constants for move in self.moves if one.moved(move) is not None)
        return f"{WATCHED} {'; '.join(known)}"

    def ask(self) -> Answer:
        """Where what a constant is made of goes where it can't be followed, all are noticed."""
        start = perf_counter()
        try:
            answer, found = noticed(lambda: answered(self.case), self.constants, self.moves)
        except (TypeError, IndexError, AttributeError) as error:
            return Answer(None, "", f"can't be followed: {error}", perf_counter() - start)
        return Answer(**asdict(answer) | {"noticed": tuple(sorted(found))})


WATCHED = "watched"


def run_all(jobs: Sequence[Job | Watch], kept: Path, processes: int) -> Iterator[tuple[Job | Watch, Answer]]:
    """As they come."""
    from joblib import Parallel, delayed

    work = Parallel(processes, return_as="generator_unordered", batch_size=1)
    yield from work(delayed(run)(job, kept) for job in jobs)


def run(job: Job | Watch, kept: Path) -> tuple[Job | Watch, Answer]:
    """From what is kept, where it is."""
    path = kept / f"{_digest(job)}.json"
    if path.is_file():
        document = json.loads(path.read_text(encoding="utf-8"))["answer"]
        return job, Answer(**document | {"noticed": tuple((name, move) for name, move in document["noticed"])})
    answer = job.ask()
    constant, move, case = job.place
    kept.mkdir(parents=True, exist_ok=True)
    document = finite({"case": case, "constant": constant, "move": move, "answer": asdict(answer)})
    write_atomically(path, json.dumps(document, indent=1, allow_nan=False) + "\n")
    return job, answer


def answered(case: Case) -> Answer:
    """By the code as it is now."""
    start = perf_counter()
    try:
        with np.errstate(all="ignore"):
            report = finite(diagnose(*case.read()).report.as_dict())
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


def unnoticed(job: Job, answers: Answers) -> Answer | None:
    """What is said with a constant moved that nothing noticed: the same as with all as it is."""
    base, watched = answers[Job(job.case).place], answers[Watch(job.case, (), ()).place]
    name, move, _ = job.place
    is_followed = base.digest != "" and watched.digest == base.digest
    return base if is_followed and (name, move) not in watched.noticed else None


def _digest(job: Job | Watch) -> str:
    whole = hashlib.sha256(f"{code_version()} {job.case.name} {job.setting}\0".encode())
    for path in job.case.files:
        whole.update(path.read_bytes())
    return whole.hexdigest()[:24]


def _set(constant: Constant, move: str) -> str:
    return f"{constant.module}.{constant.name} = {constant.moved(move)!r}"
