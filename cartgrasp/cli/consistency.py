"""`cartgrasp study consistency`."""

from __future__ import annotations

from pathlib import Path

from ..studies.consistency import MODELS, SQUARES, run_seeds
from ..studies.consistency_figures_of_merit import COLUMNS, SCORE_COLUMNS, as_dict, claims, rows, score_rows
from ..studies.consistency_plots import save_plots
from .output import make_folder, progress
from .study_report import Section, StudyReport, usual_workers


def run(out: Path, as_json: bool, seed: int, runs: int) -> int:
    make_folder(out)
    with progress("consistency") as tell:
        found = run_seeds(range(seed, seed + runs), usual_workers(), tell)
    save_plots(found, out)
    promised = claims(found)
    sections = [
        Section("Normalised squares, means over the runs", COLUMNS, rows(found), left=2),
        Section.of_claims("Claims", promised),
        Section("Parameters: rms errors in standard deviations", SCORE_COLUMNS, score_rows(found), left=2),
    ]
    squares = [as_dict(found, model, square) for model in MODELS for square in SQUARES]
    document = {"seed": seed, "runs": runs, "squares": squares}
    made_by = f"--seed {seed} --runs {runs}"
    return StudyReport("consistency", "Consistency", made_by, sections, document, promised).finish(out, as_json)
