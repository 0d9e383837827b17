"""How a study ends: its tables in a Markdown file and on the screen or as JSON, and an exit status by its promises."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..studies.claims import CLAIM_COLUMNS, Claim, all_kept, markdown_table
from ..writing import write_atomically
from .output import print_json, print_table, say

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


@dataclass(frozen=True)
class Findings:
    """`document` is what JSON says beside promises and place, `promised` what the exit status is about."""

    sections: Sequence[Section]
    document: dict[str, Any]
    promised: Sequence[Claim]


def finish(called: tuple[str, str], options: str, found: Findings, out: Path, as_json: bool) -> int:
    """Tells what a study found that is `called` by a name and a heading, and writes NAME.md into the folder `out`;
    0 if all promises are kept, else 1."""
    name, heading = called
    parts = [f"# {heading}", f"Made by `cartgrasp study {name} {options}`."]
    parts += [f"## {one.title}\n\n{markdown_table(one.columns, one.rows)}" for one in found.sections]
    write_atomically(out / f"{name}.md", "\n\n".join(parts))
    kept = all_kept(found.promised)
    if as_json:
        promises = [claim.as_dict() for claim in found.promised]
        print_json({**found.document, "promises": promises, "kept": kept, "out": str(out)})
    else:
        for one in found.sections:
            print_table(one.title, one.columns, one.rows, one.left)
    say(f"tables and plots are in {out}")
    return 0 if kept else 1


def usual_workers() -> int:
    """Processes for a study."""
    return max(1, min(os.cpu_count() or 1, MAX_WORKERS))
