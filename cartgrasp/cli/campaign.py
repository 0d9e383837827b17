"""`cartgrasp campaign STUDY.yaml`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ..strict_json import finite
from ..studies.campaigns.campaign import Results, run_campaign
from ..studies.campaigns.closed_loop import ClosedLoopStudy
from ..studies.campaigns.study_file import read_study
from ..studies.campaigns.summary import (
    LOG_COLUMNS,
    PARAMETER_COLUMNS,
    TRACKING_COLUMNS,
    LogsSummary,
    RunsSummary,
)
from ..studies.campaigns.workers import Workers, on_cluster, over_cores
from ..writing import together, write_atomically
from .output import make_folder, print_json, print_table, progress, say
from .study_report import usual_workers


def run(path: Path, out: Path, workers: int | None, scheduler: str | None, as_json: bool) -> int:
    study = read_study(path)
    make_folder(out)
    done_by: Workers = over_cores(workers or usual_workers()) if scheduler is None else on_cluster(scheduler)
    with progress(study.name) as tell:
        results = run_campaign(study, Results.under(out), done_by, tell)
    with together():
        if isinstance(study, ClosedLoopStudy):
            summary: RunsSummary | LogsSummary = _runs(results, out)
        else:
            summary = LogsSummary.of(results, [str(path) for path in study.paths])
        document = {"name": study.name, **summary.as_dict(), "out": str(out)}
        write_atomically(out / "campaign.json", json.dumps(finite(document), indent=1, allow_nan=False) + "\n")
    if as_json:
        print_json(document)
    else:
        _print(study.name, summary)
    for message, count in summary.failures.items():
        say(f"{count} failed: {message}")
    say(f"the summary is {out / 'campaign.json'}, each result is in {out / 'results'}")
    return 1 if summary.failures else 0


def _runs(results: list[dict[str, Any]], out: Path) -> RunsSummary:
    summary = RunsSummary.of(results)
    if good := [one for one in results if "failure" not in one]:
        from ..studies.campaigns.plots import save_plot

        save_plot(good, [one.name for one in summary.parameters], out)
    return summary


def _print(name: str, summary: RunsSummary | LogsSummary) -> None:
    if isinstance(summary, LogsSummary):
        print_table(f"{name}: {len(summary.logs)} logs", LOG_COLUMNS, summary.parameter_cells)
        verdicts = [(one["log"], one["verdict"], ", ".join(one["effects"])) for one in summary.logs if "verdict" in one]
        if verdicts:
            print_table("Diagnoses", ("log", "verdict", "effects"), verdicts, left=3)
        return
    title = f"{name}: {summary.runs} runs, {100 * summary.optimal:.1f} % of the plans optimal"
    if summary.healths:
        title += f"; health at the end: {', '.join(f'{word} {count}' for word, count in summary.healths.items())}"
    print_table(title, TRACKING_COLUMNS, summary.tracking_cells)
    if summary.parameters:
        print_table("Parameters at the end", PARAMETER_COLUMNS, [one.cells for one in summary.parameters])
