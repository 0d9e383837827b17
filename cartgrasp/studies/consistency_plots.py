"""Normalised squares over time beside their bands: functions that draw into the `Axes` they are given."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..view.figures import save_figure
from ..view.plots import OKABE_ITO, house_style
from .consistency import MODELS, SQUARES, Trace
from .consistency_figures_of_merit import Consistency, consistency

LOG_SCALE_RATIO = 3.0
"""Times its band: what goes higher is drawn in decades."""


def draw_square(axes: Axes, found: Consistency) -> None:
    """The mean over the runs by its dimension, and the band that 95 % of the steps should be in."""
    axes.axhspan(found.low, found.high, color=OKABE_ITO[0], alpha=0.2, linewidth=0, label="95 % of steps")
    axes.plot(found.time, found.mean, color=OKABE_ITO[1], linewidth=0.7, label="mean over the runs")
    width, highest = found.high - found.low, float(found.mean.max())
    if highest > LOG_SCALE_RATIO * found.high:
        axes.set_yscale("log")
        axes.set_ylim(0.5 * found.low, 2 * highest)
    else:
        axes.set_ylim(found.low - 1.5 * width, max(found.high + 1.5 * width, highest + 0.2 * width))


def figure_consistency(runs: Sequence[dict[str, Trace]]) -> Figure:
    """A page: squares down, models across."""
    with house_style():
        figure = Figure(figsize=(7.2, 7.2), layout="constrained")
        panels = figure.subplots(len(SQUARES), len(MODELS), sharex=True)
        for row, square in zip(panels, SQUARES, strict=True):
            for axes, model in zip(row, MODELS, strict=True):
                draw_square(axes, consistency(runs, model, square))
            row[0].set_ylabel(square)
        for axes, model in zip(panels[0], MODELS, strict=True):
            axes.set_title(model)
        for axes in panels[-1]:
            axes.set_xlabel("Time (s)")
        figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return figure


def save_plots(runs: Sequence[dict[str, Trace]], out: Path) -> Path:
    """Writes `consistency.png` into a folder."""
    return save_figure(figure_consistency(runs), out / "consistency.png")
