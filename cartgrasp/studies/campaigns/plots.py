"""A campaign's figure: functions that draw into the `Axes` they are given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...view.figures import save_figure
from ...view.plots import GREEN, PURPLE, house_style

PLOT_COLUMNS = 3


def draw_errors(axes: Axes, results: Sequence[Mapping[str, Any]], name: str) -> None:
    """Error of a parameter over time: its mean over the runs, where 68 % of them are, and dashed the standard
    deviation that was claimed on average."""
    time = np.array(results[0]["series"]["time"])
    found = [one["series"]["parameters"][name] for one in results]
    truth = np.array([one["parameters"][name]["truth"] for one in results])
    error = np.array([one["value"] for one in found]) - truth[:, None]
    std = np.sqrt(np.mean(np.square([one["std"] for one in found]), axis=0))
    low, high = np.percentile(error, [16, 84], axis=0)
    axes.fill_between(time, low, high, color=PURPLE, alpha=0.25, linewidth=0)
    axes.plot(time, error.mean(axis=0), color=PURPLE)
    for sign in (-1, 1):
        axes.plot(time, sign * std, color="black", linestyle="--", linewidth=0.8)
    axes.set_xlabel("Time (s)")
    axes.set_ylabel(f"Error of {name} ({results[0]['parameters'][name]['unit']})")


def draw_tracking(axes: Axes, results: Sequence[Mapping[str, Any]]) -> None:
    """Distance from the reference over time: its median, and below which 95 % of the runs are."""
    time = np.array(results[0]["series"]["time"])
    error = 100.0 * np.array([one["series"]["tracking_error"] for one in results])
    axes.fill_between(time, 0.0, np.percentile(error, 95, axis=0), color=GREEN, alpha=0.25, linewidth=0)
    axes.plot(time, np.median(error, axis=0), color=GREEN)
    axes.set_xlabel("Time (s)")
    axes.set_ylabel("Tracking error (cm)")
    axes.set_ylim(bottom=0.0)


def figure_campaign(results: Sequence[Mapping[str, Any]], names: Sequence[str]) -> Figure:
    """Tracking, and each of these parameters."""
    with house_style():
        down = -(-(len(names) + 1) // PLOT_COLUMNS)
        figure = Figure(figsize=(2.8 * PLOT_COLUMNS, 2.2 * down), layout="constrained")
        first, *others = figure.subplots(down, PLOT_COLUMNS, squeeze=False).ravel()
        draw_tracking(first, results)
        for axes, name in zip(others, names, strict=False):
            draw_errors(axes, results, name)
        for axes in others[len(names) :]:
            axes.remove()
    return figure


def save_plot(results: Sequence[Mapping[str, Any]], names: Sequence[str], out: Path) -> Path:
    """Writes `campaign.png` into a folder."""
    return save_figure(figure_campaign(results, names), out / "campaign.png")
