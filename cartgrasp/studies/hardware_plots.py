"""Mass over time in the hardware study, as in the paper's Fig. 9: a function that draws into the `Axes` it is given."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..view.figures import save_figure
from ..view.plots import OKABE_ITO, house_style
from .hardware import Outcome

MASS_MARGIN_FRACTION = 0.4
"""Share of the mass that is shown above and below it."""


def draw_mass(axes: Axes, outcome: Outcome) -> None:
    """Each run, what 95 % of the filter's own intervals say around their mean, the truth, and the reversals."""
    mass = outcome.experiment.mass
    runs = axes.plot(outcome.time, outcome.mass[:10].T, color=OKABE_ITO[0], linewidth=0.4, alpha=0.6)
    runs[0].set_label("runs")
    mean, std = outcome.mass.mean(axis=0), outcome.std.mean(axis=0)
    low, high = mean - 1.96 * std, mean + 1.96 * std
    axes.fill_between(outcome.time, low, high, color=OKABE_ITO[1], alpha=0.2, linewidth=0, label="95 % intervals, mean")
    axes.axhline(mass, color="black", linewidth=0.8, label="truth")
    for i, time in enumerate(outcome.reversals):
        axes.axvline(time, color=OKABE_ITO[2], linewidth=0.6, linestyle=":", label="" if i else "reversals")
    axes.set(
        ylim=(mass * (1 - MASS_MARGIN_FRACTION), mass * (1 + MASS_MARGIN_FRACTION)), xlim=(0.0, float(outcome.time[-1]))
    )
    axes.set_title(", ".join(dict.fromkeys((outcome.experiment.name, f"{mass:g} kg", outcome.experiment.casters))))


def figure_hardware(outcomes: Sequence[Outcome]) -> Figure:
    """A page, two experiments a row."""
    with house_style():
        figure = Figure(figsize=(7.2, 1.9 * ((len(outcomes) + 1) // 2)), layout="constrained")
        panels = np.ravel(figure.subplots((len(outcomes) + 1) // 2, 2))
        for axes, outcome in zip(panels, outcomes, strict=False):
            draw_mass(axes, outcome)
            axes.set(xlabel="Time (s)", ylabel="Mass (kg)")
        for axes in panels[len(outcomes) :]:
            axes.set_axis_off()
        labelled = {
            label: line for axes in panels for line, label in zip(*axes.get_legend_handles_labels(), strict=True)
        }
        figure.legend(labelled.values(), labelled.keys(), loc="outside upper center", ncols=len(labelled))
    return figure


def save_plots(outcomes: Sequence[Outcome], out: Path) -> Path:
    """Writes `hardware.png` into a folder."""
    return save_figure(figure_hardware(outcomes), out / "hardware.png")
