"""`cartgrasp study table1`."""

from __future__ import annotations

from pathlib import Path

from ..errors import UsageError
from ..studies.findings import Findings, Section
from ..studies.table1 import ROWS, Row, gain_curve, run_rows
from ..studies.table1_report import comparison, paper_claims, row_claims, save_plots
from .output import make_folder, progress
from .study_report import finish, usual_workers

GAIN_SCALES = (1.0, 0.5, 0.25, 0.15, 0.1)
ERROR_COLUMNS = ("test", "with estimation", "first guess kept", "literal filter")


def run(out: Path, as_json: bool, seed: int, tests: str) -> int:
    rows = _rows(tests)
    make_folder(out)
    with progress("Table I") as tell:
        results = run_rows(rows, seed, usual_workers(), tell)
    curve = gain_curve(GAIN_SCALES, seed) if any(row.test == 1 for row in rows) else []
    promised = [claim for result in results for claim in row_claims(result)]
    papers = paper_claims(results, curve)
    errors = [(str(result.row.test), *comparison(result)) for result in results]
    save_plots(results, curve, out)
    sections = [
        Section("Largest tracking error from 5 s on", ERROR_COLUMNS, errors),
        Section.of_claims("The paper's claims", papers),
        Section.of_claims("This project's promises", promised),
    ]
    document = {
        "seed": seed,
        "paper": [claim.as_dict() for claim in papers],
        "tracking_error": [dict(zip(ERROR_COLUMNS, row, strict=True)) for row in errors],
    }
    return finish("table1", f"--seed {seed}", Findings("Table I", sections, document, promised), out, as_json)


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
