"""`cartgrasp study excitation`."""

from __future__ import annotations

from pathlib import Path

from ..studies.excitation import run_ways
from ..studies.excitation_figures_of_merit import COLUMNS, PRICE_COLUMNS, as_dict, claims, price_rows, rows
from ..studies.excitation_plots import save_plots
from .output import make_folder, progress
from .study_report import Section, StudyReport, usual_workers

ALLOWANCES_TITLE = "What an allowance buys: standard deviations foretold (criterion D; kg, m, m, kg·m²)"
DEVIATIONS_TITLE = "Standard deviations at the end (kg, m, m, kg·m²)"


def run(out: Path, as_json: bool, seed: int, seeds: int) -> int:
    make_folder(out)
    with progress("excitation") as tell:
        drives = run_ways(seeds, seed, usual_workers(), tell)
    save_plots(drives, out)
    promised = claims(drives)
    sections = [
        Section(DEVIATIONS_TITLE, COLUMNS, rows(drives)),
        Section(ALLOWANCES_TITLE, PRICE_COLUMNS, price_rows()),
        Section.of_claims("Claims", promised),
    ]
    document = {"seed": seed, "seeds": seeds, "ways": [as_dict(drive) for drive in drives]}
    made_by = f"--seed {seed} --seeds {seeds}"
    return StudyReport("excitation", "Excitation", made_by, sections, document, promised).finish(out, as_json)
