"""`cartgrasp study robust`."""

from __future__ import annotations

from pathlib import Path

from ..studies.robust_margins import run_seeds
from ..studies.robust_margins_figures_of_merit import COLUMNS, as_dict, claims, rows
from ..studies.robust_margins_plots import save_plots
from .output import make_folder, progress
from .study_report import Section, StudyReport, usual_workers

MARGINS_TITLE = "Margins while the load is learned (at hard ticks; effort in N²)"


def run(out: Path, as_json: bool, seed: int, seeds: int) -> int:
    make_folder(out)
    with progress("robust margins") as tell:
        runs = run_seeds(range(seed, seed + seeds), usual_workers(), tell)
    save_plots(runs, out)
    promised = claims(runs)
    sections = [Section(MARGINS_TITLE, COLUMNS, rows(runs)), Section.of_claims("Claims", promised)]
    document = {"seed": seed, "seeds": seeds, "runs": [as_dict(one) for one in runs]}
    made_by = f"--seed {seed} --seeds {seeds}"
    return StudyReport("robust", "Robust margins", made_by, sections, document, promised).finish(out, as_json)
