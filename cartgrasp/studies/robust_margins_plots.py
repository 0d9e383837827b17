"""Margins that shrink as the load is learned, and what they save: functions that draw into given `Axes`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..view.figures import save_figure
from ..view.plots import OKABE_ITO, house_style
from .robust_margins import LAP_TIMES, WAYS, Run

STYLES = ("--", "-", ":")


def draw_reserve(axes: Axes, runs: Sequence[Run]) -> list[Artist]:
    """The largest margin of the plans against time: each run, and the mean."""
    artists: list[Artist] = []
    for run in runs:
        artists += axes.plot(run.time, run.reserve, color=OKABE_ITO[1], linewidth=0.5, alpha=0.4)
    mean = np.mean([run.reserve for run in runs], axis=0)
    artists += axes.plot(runs[0].time, mean, color=OKABE_ITO[1], label=WAYS[1])
    axes.set(xlabel="Time (s)", ylabel="Largest margin (N)")
    return artists


def draw_room(axes: Axes, runs: Sequence[Run]) -> list[Artist]:
    """How far the true carts are inside their limits: of each way the mean, and the range over runs."""
    artists: list[Artist] = [axes.axhline(0.0, color="0.3", linewidth=0.8)]
    time, room = runs[0].time, np.array([run.room for run in runs])
    for i, way in enumerate(WAYS[:2]):
        low, high = room[..., i].min(axis=0), room[..., i].max(axis=0)
        artists.append(axes.fill_between(time, low, high, color=OKABE_ITO[i], alpha=0.25, linewidth=0.0))
        artists += axes.plot(time, room[..., i].mean(axis=0), STYLES[i], color=OKABE_ITO[i], label=way)
    axes.set(xlabel="Time (s)", ylabel="True load above its limit (N)")
    return artists


def draw_effort(axes: Axes, runs: Sequence[Run]) -> list[Artist]:
    """Effort of each way against time, mean over runs."""
    artists: list[Artist] = []
    efforts = np.mean([run.efforts for run in runs], axis=0)
    for i, way in enumerate(WAYS):
        artists += axes.plot(runs[0].time, efforts[:, i], STYLES[i], color=OKABE_ITO[i], label=way)
    axes.set(xlabel="Time (s)", ylabel="Effort (N²)")
    return artists


def figure_robust_margins(runs: Sequence[Run]) -> Figure:
    """A page: margins, what is left to the true limits, effort; grey where the path curves."""
    with house_style():
        figure = Figure(figsize=(7.2, 5.6), layout="constrained")
        axes = figure.subplots(3, 1, sharex=True)
        for panel, draw in zip(axes, (draw_reserve, draw_room, draw_effort), strict=True):
            panel.axvspan(LAP_TIMES[2], LAP_TIMES[-1], color="0.94", zorder=0)
            draw(panel, runs)
            panel.label_outer()
        for start, stop, path in ((0.0, LAP_TIMES[2], "straight"), (LAP_TIMES[2], LAP_TIMES[-1], "curved")):
            axes[0].text((start + stop) / 2, 0.97, path, transform=axes[0].get_xaxis_transform(), ha="center", va="top")
        figure.legend(*axes[2].get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


def save_plots(runs: Sequence[Run], out: Path) -> Path:
    """Writes `robust.png` into a folder."""
    return save_figure(figure_robust_margins(runs), out / "robust.png")
