"""`cartgrasp study estimators`."""

from __future__ import annotations

from pathlib import Path

from ..studies.estimators import run_trials
from ..studies.estimators_figures_of_merit import (
    BETTER_COLUMNS,
    COLUMNS,
    MOTION_COLUMNS,
    as_dict,
    better_rows,
    claims,
    motion_rows,
    rows,
)
from .output import make_folder, progress
from .study_report import Section, StudyReport, usual_workers

COMPARISON_TITLE = "When which is better: errors of the filter over those of the regressor"
PARAMETERS_TITLE = "Rms errors at the end (mean error of the mass beside), and rms errors in standard deviations (z)"


def run(out: Path, as_json: bool, seed: int, seeds: int) -> int:
    make_folder(out)
    with progress("estimators") as tell:
        trials = run_trials(range(seed, seed + seeds), usual_workers(), tell)
    promised = claims(trials)
    sections = [
        Section(COMPARISON_TITLE, BETTER_COLUMNS, better_rows(trials), left=2),
        Section.of_claims("Claims", promised),
        Section(PARAMETERS_TITLE, COLUMNS, rows(trials), left=2),
        Section(
            "Rms errors of the motion on the way, and the time of a row", MOTION_COLUMNS, motion_rows(trials), left=2
        ),
    ]
    document = {"seed": seed, "seeds": seeds, "trials": [as_dict(trial) for trial in trials]}
    made_by = f"--seed {seed} --seeds {seeds}"
    return StudyReport("estimators", "Estimators", made_by, sections, document, promised).finish(out, as_json)
