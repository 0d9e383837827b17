"""The logs of an ablation, each with the exam that judges what is said of it: sealed ones, and measured ones."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, zip_longest
from pathlib import Path
from typing import Any

from cartgrasp.cart_file import load_cart
from cartgrasp.logs import RunLog, read_log
from cartgrasp.model import CartModel

from ..measured import judging as measured
from ..measured.logs import LOGS, MeasuredLog
from ..measured.running import COMMANDS, Answer, Outcome
from ..measured.variants import AS_IT_IS
from ..sealed import judging as sealed
from ..sealed.score import contents

KINDS = ("single", "pair", "nothing", "outside", "measured")


@dataclass(frozen=True)
class Mark:
    """Of one log: whether what it asks for was said, how many names are wrong, and by which share the mass is (None:
    nothing to judge)."""

    is_right: bool
    wrong: int
    mass_error: float | None


class Case(ABC):
    """One log with its truth. Frozen, so that it can be handed to another process."""

    @property
    @abstractmethod
    def name(self) -> str: ...

    @property
    @abstractmethod
    def kind(self) -> str:
        """One of KINDS."""

    @property
    @abstractmethod
    def what(self) -> str:
        """Logs of which this is the same differ by chance."""

    @property
    @abstractmethod
    def files(self) -> tuple[Path, ...]:
        """All that a verdict follows from, but for code."""

    @abstractmethod
    def read(self) -> tuple[RunLog, CartModel]: ...

    @abstractmethod
    def mark(self, report: Mapping[str, Any] | None, failure: str) -> Mark:
        """Of a report's contents; None where there is none, for a reason."""


@dataclass(frozen=True)
class SealedCase(Case):
    """Of a folder as `benchmarks.sealed` makes it: logs/NAME/run.csv and cart.yaml, truth/NAME.json."""

    folder: Path
    log: str

    @property
    def name(self) -> str:
        return self.log

    @cached_property
    def truth(self) -> Mapping[str, Any]:
        return contents(self.folder / "truth" / f"{self.log}.json")

    @property
    def kind(self) -> str:
        return sealed.Judgement(self.truth, None).kind

    @property
    def what(self) -> str:
        return str(self.truth["case"])

    @property
    def files(self) -> tuple[Path, ...]:
        there = self.folder / "logs" / self.log
        return there / "run.csv", there / "cart.yaml"

    def read(self) -> tuple[RunLog, CartModel]:
        log, cart = self.files
        return read_log(log), load_cart(cart)

    def mark(self, report: Mapping[str, Any] | None, failure: str) -> Mark:
        judged = sealed.Judgement(self.truth, report)
        masses = [abs(e.error) / e.truth for e in judged.mismatches if e.name == "mass"]
        return Mark(judged.right, len(judged.wrong_names), next(iter(masses), None))


@dataclass(frozen=True)
class MeasuredCase(Case):
    """A log of the folder `data`, as it is; its mass is known in an interval, so that it has no error."""

    data: Path
    number: int

    @property
    def log(self) -> MeasuredLog:
        return LOGS[self.number]

    @property
    def name(self) -> str:
        return self.log.name

    @property
    def kind(self) -> str:
        return "measured"

    @property
    def what(self) -> str:
        return self.name

    @property
    def files(self) -> tuple[Path, ...]:
        return (self.data / self.log.path,)

    def read(self) -> tuple[RunLog, CartModel]:
        return read_log(*self.files), self.log.cart

    def mark(self, report: Mapping[str, Any] | None, failure: str) -> Mark:
        answers = {command: Answer() for command in COMMANDS} | {"discrepancy": Answer(report or {}, failure)}
        judged = measured.Judgement(
            self.log, Outcome(self.log.name, AS_IT_IS.name, self.log.cart.inertia.mass, answers)
        )
        allowed = self.log.truth.allowed
        wrong = [n for n in judged.names if n.probability > measured.SURE and not n.either & allowed]
        return Mark(judged.is_right, len(wrong), None)


def sealed_cases(folders: Iterable[Path]) -> list[Case]:
    """But for those that are kept for proof: of these only totals are looked at."""
    found = [SealedCase(folder, path.stem) for folder in folders for path in sorted((folder / "truth").glob("*.json"))]
    return [case for case in found if not sealed.Judgement(case.truth, None).is_proof]


def measured_cases(data: Path) -> list[Case]:
    return [MeasuredCase(data, i) for i, log in enumerate(LOGS) if (data / log.path).is_file()]


def spread(cases: Sequence[Case], count: int) -> list[Case]:
    """So many: of each kind in turn, and of each kind what has not been taken yet first."""
    taken = [chain.from_iterable(_by([c for c in cases if c.kind == kind])) for kind in KINDS]
    every = (case for row in zip_longest(*taken) for case in row if case is not None)
    return [case for case, _ in zip(every, range(count), strict=False)]


def _by(cases: Sequence[Case]) -> list[list[Case]]:
    """One of each `what`, then another of each, and so on."""
    groups: dict[str, list[Case]] = defaultdict(list)
    for case in sorted(cases, key=lambda c: (c.what, c.name)):
        groups[case.what].append(case)
    rows = zip_longest(*groups.values())
    return [[case for case in row if case is not None] for row in rows]
