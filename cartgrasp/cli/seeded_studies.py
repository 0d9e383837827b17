"""The studies that take a folder, a seed and how many runs, and nothing else: what each runs, tells and draws."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

from ..view.figures import save_figure
from .output import make_folder, progress
from .study_report import Findings, Section, finish, usual_workers

Tell = Callable[[float], None]
"""Takes the share done."""


def run(name: str, counted: str, out: Path, as_json: bool, seed: int, count: int) -> int:
    """`counted`, seeds or runs, is what the study's option and JSON call what there are `count` of."""
    heading, doing, study = SEEDED_STUDIES[name]
    make_folder(out)
    with progress(doing) as tell:
        found = study(range(seed, seed + count), out, tell)
    found = replace(found, document={"seed": seed, counted: count, **found.document})
    return finish((name, heading), f"--seed {seed} --{counted} {count}", found, out, as_json)


def _consistency(seeds: range, out: Path, tell: Tell) -> Findings:
    from ..studies.consistency import MODELS, SQUARES, run_seeds
    from ..studies.consistency_report import COLUMNS, SCORE_COLUMNS, as_dict, claims, rows, save_plots, score_rows

    found = run_seeds(seeds, usual_workers(), tell)
    save_plots(found, out)
    promised = claims(found)
    sections = [
        Section("Normalised squares, means over the runs", COLUMNS, rows(found), left=2),
        Section.of_claims("Claims", promised),
        Section("Parameters: rms errors in standard deviations", SCORE_COLUMNS, score_rows(found), left=2),
    ]
    squares = [as_dict(found, model, square) for model in MODELS for square in SQUARES]
    return Findings(sections, {"squares": squares}, promised)


def _disturbances(seeds: range, out: Path, tell: Tell) -> Findings:
    from ..studies.disturbances import run_cases
    from ..studies.disturbances_report import COLUMNS, as_dict, claims, rows

    outcomes = run_cases(seeds, usual_workers(), tell)
    promised = claims(outcomes)
    title = "Errors from the first disturbance on: rms over the runs, and the mean of their peaks"
    sections = [Section(title, COLUMNS, rows(outcomes), left=2), Section.of_claims("Claims", promised)]
    return Findings(sections, {"outcomes": [as_dict(one) for one in outcomes]}, promised)


def _effort(seeds: range, out: Path, tell: Tell) -> Findings:
    from ..studies import effort_report
    from ..studies.effort import run_seeds

    return _reported(run_seeds(seeds, usual_workers(), tell), effort_report, out / "effort.png")


def _estimators(seeds: range, out: Path, tell: Tell) -> Findings:
    from ..studies import estimators_report as merits
    from ..studies.estimators import run_trials

    trials = run_trials(seeds, usual_workers(), tell)
    promised = merits.claims(trials)
    better = "When which is better: errors of the filter over those of the regressor"
    errors = "Rms errors at the end (mean error of the mass beside), and rms errors in standard deviations (z)"
    motion = "Rms errors of the motion on the way, and the time of a row"
    sections = [
        Section(better, merits.BETTER_COLUMNS, merits.better_rows(trials), left=2),
        Section.of_claims("Claims", promised),
        Section(errors, merits.COLUMNS, merits.rows(trials), left=2),
        Section(motion, merits.MOTION_COLUMNS, merits.motion_rows(trials), left=2),
    ]
    return Findings(sections, {"trials": [merits.as_dict(trial) for trial in trials]}, promised)


def _excitation(seeds: range, out: Path, tell: Tell) -> Findings:
    from ..studies.excitation import run_ways
    from ..studies.excitation_report import COLUMNS, PRICE_COLUMNS, as_dict, claims, price_rows, rows, save_plots

    drives = run_ways(len(seeds), seeds.start, usual_workers(), tell)
    save_plots(drives, out)
    promised = claims(drives)
    allowances = "What an allowance buys: standard deviations foretold (criterion D; kg, m, m, kg·m²)"
    sections = [
        Section("Standard deviations at the end (kg, m, m, kg·m²)", COLUMNS, rows(drives)),
        Section(allowances, PRICE_COLUMNS, price_rows()),
        Section.of_claims("Claims", promised),
    ]
    return Findings(sections, {"ways": [as_dict(drive) for drive in drives]}, promised)


def _hardware(seeds: range, out: Path, tell: Tell) -> Findings:
    from ..studies import hardware_report as merits
    from ..studies.hardware import run_experiments

    outcomes = run_experiments(len(seeds), seeds.start, usual_workers(), tell)
    merits.save_plots(outcomes, out)
    promised, papers = merits.claims(outcomes), merits.paper_claims(outcomes)
    sections = [
        Section("Mass, and rms errors of the rest", merits.COLUMNS, merits.rows(outcomes), left=2),
        Section("E5: the mass after each reversal", merits.REVERSAL_COLUMNS, merits.reversal_rows(outcomes)),
        Section.of_claims("The paper's claims", papers),
        Section.of_claims("This project's promises", promised),
    ]
    experiments = [merits.as_dict(outcome) for outcome in outcomes]
    return Findings(sections, {"paper": [claim.as_dict() for claim in papers], "experiments": experiments}, promised)


def _robust(seeds: range, out: Path, tell: Tell) -> Findings:
    from ..studies.robust_margins import run_seeds
    from ..studies.robust_margins_report import COLUMNS, as_dict, claims, rows, save_plots

    runs = run_seeds(seeds, usual_workers(), tell)
    save_plots(runs, out)
    promised = claims(runs)
    title = "Margins while the load is learned (at hard ticks; effort in N²)"
    sections = [Section(title, COLUMNS, rows(runs)), Section.of_claims("Claims", promised)]
    return Findings(sections, {"runs": [as_dict(one) for one in runs]}, promised)


def _safety(seeds: range, out: Path, tell: Tell) -> Findings:
    from ..studies import safety_report
    from ..studies.safety import run_seeds

    return _reported(run_seeds(seeds, usual_workers(), tell), safety_report, out / "safety.png")


def _reported(found: Sequence[Any], report: ModuleType, picture: Path) -> Findings:
    """As a module with `tables` (title, columns, rows), `claims`, `as_dict` and a `figure` reports it."""
    save_figure(report.figure(found), picture)
    promised = report.claims(found)
    sections = [*(Section(*table) for table in report.tables(found)), Section.of_claims("Claims", promised)]
    return Findings(sections, {"runs": [report.as_dict(one) for one in found]}, promised)


SEEDED_STUDIES: dict[str, tuple[str, str, Callable[[range, Path, Tell], Findings]]] = {
    "consistency": ("Consistency", "consistency", _consistency),
    "disturbances": ("Disturbances", "disturbances", _disturbances),
    "effort": ("What hands pay at equal tracking error", "effort", _effort),
    "estimators": ("Estimators", "estimators", _estimators),
    "excitation": ("Excitation", "excitation", _excitation),
    "hardware": ("The hardware experiments", "hardware experiments", _hardware),
    "robust": ("Robust margins", "robust margins", _robust),
    "safety": ("Carts that are not known yet, driven hard", "safety", _safety),
}
"""Each has its report's heading, what is said while it runs, and how it is done with some seeds."""
