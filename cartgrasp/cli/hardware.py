"""`cartgrasp study hardware`."""

from __future__ import annotations

from pathlib import Path

from ..studies.hardware import run_experiments
from ..studies.hardware_figures_of_merit import (
    COLUMNS,
    REVERSAL_COLUMNS,
    as_dict,
    claims,
    paper_claims,
    reversal_rows,
    rows,
)
from ..studies.hardware_plots import save_plots
from .output import make_folder, progress
from .study_report import Section, StudyReport, usual_workers


def run(out: Path, as_json: bool, seed: int, runs: int) -> int:
    make_folder(out)
    with progress("hardware experiments") as tell:
        outcomes = run_experiments(runs, seed, usual_workers(), tell)
    save_plots(outcomes, out)
    promised, papers = claims(outcomes), paper_claims(outcomes)
    sections = [
        Section("Mass, and rms errors of the rest", COLUMNS, rows(outcomes), left=2),
        Section("E5: the mass after each reversal", REVERSAL_COLUMNS, reversal_rows(outcomes)),
        Section.of_claims("The paper's claims", papers),
        Section.of_claims("This project's promises", promised),
    ]
    document = {
        "seed": seed,
        "runs": runs,
        "paper": [claim.as_dict() for claim in papers],
        "experiments": [as_dict(outcome) for outcome in outcomes],
    }
    made_by = f"--seed {seed} --runs {runs}"
    return StudyReport("hardware", "The hardware experiments", made_by, sections, document, promised).finish(
        out, as_json
    )
