"""What each way of driving learned, and what it paid: functions that draw into the `Axes` they are given."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..view.figures import save_figure
from ..view.plots import OKABE_ITO, house_style
from .excitation import PHYSICAL_PARAMETERS, Drive

LABELS = {"mass": "mass (kg)", "com_x": "CoM x (m)", "com_y": "CoM y (m)", "inertia": "inertia (kg·m²)"}
STYLES = ("-", "--", "-.", "-", ":")


def draw_deviations(axes: Axes, drives: Sequence[Drive], parameter: str) -> list[Artist]:
    """The filter's standard deviation of a parameter against time, a line for each way."""
    artists: list[Artist] = []
    for i, drive in enumerate(drives):
        style = {"color": OKABE_ITO[i], "linestyle": STYLES[i]}
        artists += axes.semilogy(drive.time, drive.std(parameter), label=drive.way, **style)
    axes.set(xlabel="Time (s)", ylabel=f"sd of {LABELS[parameter]}")
    return artists


def draw_effort(axes: Axes, drives: Sequence[Drive]) -> list[Artist]:
    """Effort paid up to each time, a line for each way."""
    artists: list[Artist] = []
    for i, drive in enumerate(drives):
        artists += axes.plot(drive.time, drive.effort, color=OKABE_ITO[i], linestyle=STYLES[i], label=drive.way)
    axes.set(xlabel="Time (s)", ylabel="Effort paid (N²·s)")
    return artists


def draw_paths(axes: Axes, drives: Sequence[Drive]) -> list[Artist]:
    """How far the cart was driven off the undeviated reference, in its frame."""
    base = drives[0].records[0].reference_pose
    artists: list[Artist] = []
    for i, drive in enumerate(drives):
        pose = drive.records[0].pose
        off = pose[:, :2] - base[:, :2]
        left = off[:, 1] * np.cos(base[:, 2]) - off[:, 0] * np.sin(base[:, 2])
        artists += axes.plot(drive.time, 100.0 * left, color=OKABE_ITO[i], linestyle=STYLES[i], label=drive.way)
    axes.set(xlabel="Time (s)", ylabel="Left of the path (cm)")
    return artists


def figure_excitation(drives: Sequence[Drive]) -> Figure:
    """A page: each parameter's standard deviation, the effort, and how far off the path."""
    with house_style():
        figure = Figure(figsize=(7.2, 5.6), layout="constrained")
        axes = figure.subplots(3, 2).ravel()
        for panel, parameter in zip(axes, PHYSICAL_PARAMETERS, strict=False):
            draw_deviations(panel, drives, parameter)
        draw_effort(axes[4], drives)
        draw_paths(axes[5], drives)
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=5)
    return figure


def save_plots(drives: Sequence[Drive], out: Path) -> Path:
    """Writes `excitation.png` into a folder."""
    return save_figure(figure_excitation(drives), out / "excitation.png")
