"""`cartgrasp study table1`."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from ..errors import UsageError
from ..studies.claims import CLAIM_COLUMNS, Claim, all_kept, markdown_table
from ..studies.table1 import ROWS, Row, gain_curve, run_rows
from ..studies.table1_figures_of_merit import comparison, paper_claims, row_claims
from ..studies.table1_plots import save_plots
from ..yaml_file import write_atomically
from .output import make_folder, print_json, print_table, progress, say

GAIN_SCALES = (1.0, 0.5, 0.25, 0.15, 0.1)
ERROR_COLUMNS = ("test", "with estimation", "first guess kept", "literal filter")


def run(out: Path, as_json: bool, seed: int, tests: str) -> int:
    rows = _rows(tests)
    make_folder(out)
    workers = max(1, min(os.cpu_count() or 1, 8))
    with progress("Table I") as tell:
        results = run_rows(rows, seed, workers, tell)
    curve = gain_curve(GAIN_SCALES, seed) if any(row.test == 1 for row in rows) else []
    promised = [claim for result in results for claim in row_claims(result)]
    papers = paper_claims(results, curve)
    errors = [(str(result.row.test), *comparison(result)) for result in results]
    save_plots(results, curve, out)
    write_atomically(out / "table1.md", _markdown(promised, papers, errors, seed))
    if as_json:
        print_json(
            {
                "seed": seed,
                "promises": [claim.as_dict() for claim in promised],
                "paper": [claim.as_dict() for claim in papers],
                "tracking_error": [dict(zip(ERROR_COLUMNS, row, strict=True)) for row in errors],
                "kept": all_kept(promised),
                "out": str(out),
            }
        )
    else:
        print_table("Largest tracking error from 5 s on", ERROR_COLUMNS, errors)
        print_table("The paper's claims", CLAIM_COLUMNS, [c.cells for c in papers], left=3)
        print_table("This project's promises", CLAIM_COLUMNS, [c.cells for c in promised], left=3)
    say(f"tables and plots are in {out}")
    return 0 if all_kept(promised) else 1


def _rows(tests: str) -> tuple[Row, ...]:
    if not tests:
        return ROWS
    known = {str(row.test): row for row in ROWS}
    wanted = [part.strip() for part in tests.split(",") if part.strip()]
    for part in wanted:
        if part not in known:
            raise UsageError(f"--rows {part}: no such test; they are 1 to {len(ROWS)}")
    if not wanted:
        raise UsageError(f"--rows {tests}: names no test; they are 1 to {len(ROWS)}")
    return tuple(known[part] for part in wanted)


def _markdown(promised: list[Claim], papers: list[Claim], errors: Sequence[Sequence[str]], seed: int) -> str:
    parts = [
        "# Table I",
        f"Made by `cartgrasp study table1 --seed {seed}`.",
        "## Largest tracking error from 5 s on",
        markdown_table(ERROR_COLUMNS, errors),
        "## The paper's claims",
        markdown_table(CLAIM_COLUMNS, [c.cells for c in papers]),
        "## This project's promises",
        markdown_table(CLAIM_COLUMNS, [c.cells for c in promised]),
    ]
    return "\n\n".join(parts)
