"""The studies that take a folder, a seed and how many runs, and nothing else."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from pathlib import Path

from ..view.figures import save_figure
from .output import make_folder, progress
from .study_report import finish, usual_workers


def run(called: tuple[str, str], counted: str, out: Path, as_json: bool, seed: int, count: int) -> int:
    """A study is `called` by its command, and by its module in `studies`, which has `run_seeds` (seeds, workers,
    progress); beside that is one for the report, with `findings` and perhaps a `figure`. `counted`, seeds or runs, is
    what the study's option and JSON call what there are `count` of."""
    name, module = called
    study, report = (import_module(f"cartgrasp.studies.{module}{part}") for part in ("", "_report"))
    make_folder(out)
    with progress(module.replace("_", " ")) as tell:
        runs = study.run_seeds(range(seed, seed + count), usual_workers(), tell)
        if hasattr(report, "figure"):
            save_figure(report.figure(runs), out / f"{name}.png")
        found = report.findings(runs)
    found = replace(found, document={"seed": seed, counted: count, **found.document})
    return finish(name, f"--seed {seed} --{counted} {count}", found, out, as_json)
