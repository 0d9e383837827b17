"""How a study ends: its tables in a Markdown file and on the screen or as JSON, and an exit status by its promises."""

from __future__ import annotations

import os
from pathlib import Path

from ..studies.findings import Findings, all_kept
from ..writing import write_atomically
from .output import print_json, print_table, say

MAX_WORKERS = 8


def finish(name: str, options: str, found: Findings, out: Path, as_json: bool) -> int:
    """Tells what a study of a name found, and writes NAME.md into the folder `out`; 0 if all promises are kept, else
    1."""
    made_by = f"Made by `cartgrasp study {name} {options}`."
    write_atomically(
        out / f"{name}.md", "\n\n".join([f"# {found.heading}", made_by, *(s.markdown for s in found.sections)])
    )
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
