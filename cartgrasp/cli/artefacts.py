"""What a run leaves in its folder: log, truth, carts, figures, and the animated page."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..logs import write_log
from ..simulation.record import RunRecord
from ..view.figures import figure_arms, figure_overview, figure_parameters, figure_tracking, save_figure
from ..view.player import write_player
from ..view.shown_run import ShownRun
from ..writing import together, write_atomically


def save_run(record: RunRecord, out: Path, title: str, prefix: str = "") -> None:
    """Writes the run's files into a folder, all at one go."""
    run = ShownRun.of_record(record)
    figures = {"overview": figure_overview, "tracking": figure_tracking, "arms": figure_arms}
    if record.parameters:
        figures["parameters"] = figure_parameters
    with together():
        write_log(record.log, out / f"{prefix}run.csv")
        _write_truth(record, out / f"{prefix}truth.csv")
        for name, draw in figures.items():
            save_figure(draw(run), out / f"{prefix}{name}.png")
        write_player(run, out / f"{prefix}player.html", title)


def _write_truth(record: RunRecord, path: Path) -> None:
    header = ["t", "x", "y", "theta", "x_reference", "y_reference", "theta_reference"]
    columns = [record.time[:, None], record.pose, record.reference_pose]
    for name, series in record.parameters.items():
        header += [name, f"{name}.std", *([f"{name}.truth"] if series.truth is not None else [])]
        columns += [series.value[:, None], series.std[:, None]]
        columns += [series.truth[:, None]] if series.truth is not None else []
    rows = (",".join(repr(v) for v in row) for row in np.hstack(columns).tolist())
    write_atomically(path, "\n".join([",".join(header), *rows]) + "\n")
