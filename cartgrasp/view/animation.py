"""A run as a moving GIF: the top view that plays, with its path."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from ..errors import UsageError
from ..yaml_file import write_atomically
from .plots import draw_path, house_style
from .shown_run import ShownRun
from .top_view import draw_top_view

FRAMES_PER_SECOND = 12
LONGEST = 20.0
"""s; longer runs are shown faster."""
DPI = 100


def write_gif(run: ShownRun, path: str | os.PathLike[str], progress: Callable[[float], None] | None = None) -> Path:
    """Writes a GIF of at most 20 s; `progress` is told the share done."""
    if Path(path).suffix.lower() != ".gif":
        raise UsageError(f"{path}: a moving picture is written as .gif")
    instants = frames_of(run)
    with house_style(), tempfile.TemporaryDirectory() as folder:
        figure = Figure(figsize=(4.8, 4.2))
        axes = figure.subplots()
        draw_path(axes, run.pose, run.reference_pose)
        shown: list[Artist] = []

        def show(k: int) -> list[Artist]:
            while shown:
                shown.pop().remove()
            i = int(instants[k])
            shown.extend(draw_top_view(axes, run, i))
            axes.set_title(f"{run.time[i]:.1f} s", loc="right")
            if progress is not None:
                progress(k / len(instants))
            return shown

        for i in {int(instants[0]), int(instants[-1])}:
            shown.extend(draw_top_view(axes, run, i))
        axes.autoscale_view()
        figure.draw_without_rendering()
        axes.set_autoscale_on(False)
        moving = FuncAnimation(figure, show, frames=len(instants), cache_frame_data=False)
        drawn = Path(folder) / "run.gif"
        moving.save(str(drawn), writer=PillowWriter(fps=FRAMES_PER_SECOND), dpi=DPI)
        return write_atomically(path, drawn.read_bytes())


def frames_of(run: ShownRun) -> np.ndarray:
    """The rows to show, evenly spaced in time; the last is the run's."""
    duration = float(run.time[-1] - run.time[0])
    count = int(min(duration, LONGEST) * FRAMES_PER_SECOND) + 1
    instants = np.linspace(run.time[0], run.time[-1], count)
    return np.minimum(np.searchsorted(run.time, instants - 1e-9), len(run.time) - 1)
