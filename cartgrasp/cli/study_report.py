"""How a study ends: its tables in a Markdown file and on the screen or as JSON, and an exit status by its promises."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from ..studies.claims import CLAIM_COLUMNS, Claim, all_kept, markdown_table
from ..view.figures import save_figure
from ..writing import write_atomically
from .output import make_folder, print_json, print_table, progress, say

MAX_WORKERS = 8


@dataclass(frozen=True)
class Section:
    """A table; its first `left` columns are text."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    left: int = 1

    @classmethod
    def of_claims(cls, title: str, claims: Sequence[Claim]) -> Section:
        return cls(title, CLAIM_COLUMNS, [claim.cells for claim in claims], left=3)

    @property
    def markdown(self) -> str:
        return f"## {self.title}\n\n{markdown_table(self.columns, self.rows)}"


@dataclass(frozen=True)
class StudyReport:
    """`made_by` is the command's options, `document` what JSON says beside promises and place, `promised` what the exit
    status is about."""

    name: str
    heading: str
    made_by: str
    sections: Sequence[Section]
    document: dict[str, Any]
    promised: Sequence[Claim]

    def finish(self, out: Path, as_json: bool) -> int:
        """Writes NAME.md into the folder `out`; 0 if all promises are kept, else 1."""
        made_by = f"Made by `cartgrasp study {self.name} {self.made_by}`."
        parts = [f"# {self.heading}", made_by, *(section.markdown for section in self.sections)]
        write_atomically(out / f"{self.name}.md", "\n\n".join(parts))
        kept = all_kept(self.promised)
        if as_json:
            promises = [claim.as_dict() for claim in self.promised]
            print_json({**self.document, "promises": promises, "kept": kept, "out": str(out)})
        else:
            for section in self.sections:
                print_table(section.title, section.columns, section.rows, section.left)
        say(f"tables and plots are in {out}")
        return 0 if kept else 1


class Report(Protocol):
    """A module that says what runs of a study come to: tables as title, columns and rows, and so on."""

    def tables(self, found: Any, /) -> Sequence[tuple[str, Sequence[str], Sequence[Sequence[str]]]]: ...

    def claims(self, found: Any, /) -> list[Claim]: ...

    def as_dict(self, one: Any, /) -> dict[str, Any]: ...

    def figure(self, found: Any, /) -> Any: ...


def run_study(
    called: tuple[str, str],
    run_seeds: Callable[..., Sequence[Any]],
    report: Report,
    *asked: Any,
) -> int:
    """The study of a name and a heading, with what its command was `asked`: folder, JSON or not, seed, how many."""
    (name, heading), (out, as_json, seed, seeds) = called, asked
    make_folder(out)
    with progress(name) as tell:
        found = run_seeds(range(seed, seed + seeds), usual_workers(), tell)
    save_figure(report.figure(found), out / f"{name}.png")
    promised = report.claims(found)
    sections = [*(Section(*table) for table in report.tables(found)), Section.of_claims("Claims", promised)]
    document = {"seed": seed, "seeds": seeds, "runs": [report.as_dict(one) for one in found]}
    made_by = f"--seed {seed} --seeds {seeds}"
    return StudyReport(name, heading, made_by, sections, document, promised).finish(out, as_json)


def usual_workers() -> int:
    """Processes for a study."""
    return max(1, min(os.cpu_count() or 1, MAX_WORKERS))
