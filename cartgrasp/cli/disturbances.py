"""`cartgrasp study disturbances`."""

from __future__ import annotations

from pathlib import Path

from ..studies.disturbances import run_cases
from ..studies.disturbances_figures_of_merit import COLUMNS, as_dict, claims, rows
from .output import make_folder, progress
from .study_report import Section, StudyReport, usual_workers

ERRORS_TITLE = "Errors from the first disturbance on: rms over the runs, and the mean of their peaks"


def run(out: Path, as_json: bool, seed: int, runs: int) -> int:
    make_folder(out)
    with progress("disturbances") as tell:
        outcomes = run_cases(range(seed, seed + runs), usual_workers(), tell)
    promised = claims(outcomes)
    sections = [Section(ERRORS_TITLE, COLUMNS, rows(outcomes), left=2), Section.of_claims("Claims", promised)]
    document = {"seed": seed, "runs": runs, "outcomes": [as_dict(one) for one in outcomes]}
    made_by = f"--seed {seed} --runs {runs}"
    return StudyReport("disturbances", "Disturbances", made_by, sections, document, promised).finish(out, as_json)
