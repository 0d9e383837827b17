"""The commands on measured logs and their variants, each in a process of its own: what it says, or how it ends.

What came of a log and a variant is kept as JSON under a digest of the code, the log and the cart file, so that what was
interrupted goes on, and nothing that is kept is of another code.
"""

from __future__ import annotations

import hashlib
import json
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from cartgrasp.errors import CartgraspError
from cartgrasp.logs import read_log, write_log
from cartgrasp.studies.campaigns.job import code_version
from cartgrasp.writing import write_atomically

from .carts import guessed
from .logs import MeasuredLog
from .variants import AS_IT_IS, Variant

ROOT = Path(__file__).parents[2]
COMMANDS = ("estimate", "identify", "discrepancy")
LONGEST = 1800.0
"""s, after which a command is ended: many times what any should take."""
SLOW = 20.0
"""s: what takes longer than a log of a minute may take is asked again, as the first may have had kernels to compile."""
KEPT = ("verdict", "sentence", "effects", "parameter_mismatch", "gap", "unexplained", "impacts", "removed", "stand_ins")
"""Of a report."""
ALONE = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MPLBACKEND": "Agg"}


@dataclass(frozen=True)
class Answer:
    """What a command said, as its `--json` has it, or its last words in `error`; and the seconds of a core that it
    took, start included, whatever else the machine did."""

    said: Mapping[str, Any] = field(default_factory=dict)
    error: str = ""
    seconds: float = 0.0


@dataclass(frozen=True)
class Outcome:
    """Of one log and variant: answers by command, from a cart believed to have `guess` (kg)."""

    log: str
    variant: str
    guess: float
    answers: Mapping[str, Answer]

    def said(self, command: str) -> Mapping[str, Any]:
        return self.answers[command].said

    @property
    def errors(self) -> tuple[str, ...]:
        """A reason that several commands give is told once."""
        told = dict.fromkeys(a.error for a in self.answers.values() if a.error)
        return tuple(f"{', '.join(c for c in COMMANDS if self.answers[c].error == why)}: {why}" for why in told)


@dataclass(frozen=True)
class Job:
    """A log of the folder `data` in a variant; what comes of it is kept in the folder `kept`."""

    log: MeasuredLog
    variant: Variant
    data: Path
    kept: Path

    @property
    def guess(self) -> float:
        """kg; of the middle of where the true mass is, where that is known."""
        own, share, true = self.log.cart.inertia.mass, self.variant.guess, self.log.truth.mass
        middle = own if true is None else (true.low + true.high) / 2
        return own if share is None else share * middle


def jobs_of(logs: Sequence[MeasuredLog], data: Path, kept: Path, with_variants: bool) -> list[Job]:
    """Logs as they are first."""
    every = [Job(log, v, data, kept) for log in logs for v in (log.variants() if with_variants else (AS_IT_IS,))]
    return sorted(every, key=lambda job: job.variant is not AS_IT_IS)


def run_all(jobs: Sequence[Job], processes: int) -> Iterator[Outcome]:
    """As they come."""
    from joblib import Parallel, delayed

    yield from Parallel(processes, return_as="generator_unordered", batch_size=1)(delayed(run)(job) for job in jobs)


def run(job: Job) -> Outcome:
    """A log that can't be read or changed has that for an answer."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cart = guessed(job.log.cart, job.guess).save(folder / "cart.yaml")
        try:
            path = _written(job, folder)
        except CartgraspError as error:
            answers = dict.fromkeys(COMMANDS, Answer(error=_without(str(error), (job.data, folder))))
        else:
            answers = _answers(path, cart, job)
        return Outcome(job.log.name, job.variant.name, job.guess, answers)


def _written(job: Job, folder: Path) -> Path:
    """The log as it is, or its variant as a CSV."""
    path = job.data / job.log.path
    if job.variant.change is AS_IT_IS.change:
        return path
    return write_log(job.variant.change(read_log(path)), folder / "run.csv")


def _answers(log: Path, cart: Path, job: Job) -> dict[str, Answer]:
    """By command; those that are kept, where there are any."""
    kept = job.kept / f"{_digest(log, cart)}.json"
    if not kept.is_file():
        told = {command: asdict(_asked(command, log, cart, (job.data, log.parent))) for command in COMMANDS}
        job.kept.mkdir(parents=True, exist_ok=True)
        write_atomically(kept, json.dumps({"log": job.log.name, "variant": job.variant.name, **told}, indent=1) + "\n")
    found = json.loads(kept.read_text(encoding="utf-8"))
    return {command: Answer(**found[command]) for command in COMMANDS}


def _digest(*paths: Path) -> str:
    whole = hashlib.sha256(code_version().encode())
    for path in paths:
        whole.update(path.read_bytes())
    return whole.hexdigest()[:20]


def _asked(command: str, log: Path, cart: Path, folders: Sequence[Path]) -> Answer:
    first = _asked_once(command, log, cart, folders)
    if first.error or first.seconds < SLOW:
        return first
    return replace(first, seconds=min(first.seconds, _asked_once(command, log, cart, folders).seconds))


def _asked_once(command: str, log: Path, cart: Path, folders: Sequence[Path]) -> Answer:
    words = [sys.executable, "-m", "cartgrasp", command, str(log), "--cart", str(cart), "--json"]
    before = _seconds_of_children()
    try:
        done = subprocess.run(
            words, cwd=ROOT, env=os.environ | ALONE, capture_output=True, text=True, timeout=LONGEST, check=False
        )
    except subprocess.TimeoutExpired:
        return Answer(error=f"has not ended after {LONGEST:g} s", seconds=LONGEST)
    seconds = _seconds_of_children() - before
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no word"])[-1]
        return Answer(error=f"status {done.returncode}, {_without(last, folders)}", seconds=seconds)
    said = json.loads(done.stdout)
    if command == "discrepancy":
        said = {key: said[key] for key in KEPT if key in said}
    return Answer(said, seconds=seconds)


def _seconds_of_children() -> float:
    """Of all that ended so far; a worker has one at a time."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _without(words: str, folders: Sequence[Path]) -> str:
    """Words that name no folder of this machine."""
    for folder in folders:
        words = words.replace(f"{folder}{os.sep}", "")
    return words
