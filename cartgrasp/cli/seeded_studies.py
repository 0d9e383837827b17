"""The studies that take a folder, a seed and how many runs, and nothing else."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from pathlib import Path

from ..view.figures import save_figure
from .output import make_folder, progress
from .study_report import finish, usual_workers

SEEDED_STUDIES = {
    "consistency": ("consistency", "Consistency", "consistency"),
    "disturbances": ("disturbances", "Disturbances", "disturbances"),
    "effort": ("effort", "What hands pay at equal tracking error", "effort"),
    "estimators": ("estimators", "Estimators", "estimators"),
    "excitation": ("excitation", "Excitation", "excitation"),
    "hardware": ("hardware", "The hardware experiments", "hardware experiments"),
    "robust": ("robust_margins", "Robust margins", "robust margins"),
    "safety": ("safety", "Carts that are not known yet, driven hard", "safety"),
}
"""Each has its module in `studies`, with `run_seeds` (seeds, workers, progress), beside one for the report, with
`findings` and perhaps a `figure`; its report's heading; and what is said while it runs."""


def run(name: str, counted: str, out: Path, as_json: bool, seed: int, count: int) -> int:
    """`counted`, seeds or runs, is what the study's option and JSON call what there are `count` of."""
    module, heading, doing = SEEDED_STUDIES[name]
    study, report = (import_module(f"cartgrasp.studies.{module}{part}") for part in ("", "_report"))
    make_folder(out)
    with progress(doing) as tell:
        runs = study.run_seeds(range(seed, seed + count), usual_workers(), tell)
        if hasattr(report, "figure"):
            save_figure(report.figure(runs), out / f"{name}.png")
        found = report.findings(runs)
    found = replace(found, document={"seed": seed, counted: count, **found.document})
    return finish((name, heading), f"--seed {seed} --{counted} {count}", found, out, as_json)
