"""Whole figures of a run and of a log, and how a figure becomes a file."""

from __future__ import annotations

import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..errors import UsageError
from ..logs.run_log import RunLog
from ..writing import write_atomically
from .plots import (
    VERMILLION,
    draw_contacts,
    draw_doubt,
    draw_forces,
    draw_moments,
    draw_motion,
    draw_parameter,
    draw_path,
    draw_tracking_error,
    house_style,
    plain_text,
)
from .shown_run import ShownRun
from .top_view import draw_top_view

FIGURE_DPI = 160
MAX_SUSPICIONS_SHOWN = 6
"""Suspicions in a log's title."""
SNAPSHOT_FRACTIONS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
"""Shares of the run at which an overview's path shows the cart."""
UNDATED_METADATA: Mapping[str, dict[str, Any]] = {
    "png": {"Software": None},
    "pdf": {"CreationDate": None, "Producer": None},
    "svg": {"Date": None},
}
"""Metadata without date or version: the same run gives the same file."""


def figure_overview(run: ShownRun) -> Figure:
    """One page: path, how the cart moved, mass and CoM, and what the arms did, if there are any."""
    estimated = [name for name in ("mass", "com_x", "com_y") if name in run.parameters]
    motion = ["speed", "yaw"] if run.reference_pose is None else ["error"]
    panels = [*motion, *estimated, *(("contacts", "forces", "moments") if run.wrenches else ())]
    n_rows = (len(panels) + 3) // 2
    n_path = 2 * n_rows - len(panels)
    with house_style():
        figure = Figure(figsize=(7.2, 1.5 * n_rows))
        left, right = figure.subfigures(1, 2, squeeze=False)[0]
        below = len(panels) - n_rows
        path, *others = left.subplots(1 + below, 1, height_ratios=[n_path, *[1] * below], squeeze=False)[:, 0]
        axes = dict(zip(panels, [*right.subplots(n_rows, 1, squeeze=False)[:, 0], *others], strict=True))
        draw_path(path, run.pose, run.reference_pose)
        for instant in SNAPSHOT_FRACTIONS:
            draw_top_view(path, run, round(instant * (len(run.time) - 1)), mark_size=2.0)
        if run.tracking_error is not None:
            draw_tracking_error(axes["error"], run.time, run.tracking_error)
        else:
            draw_motion(axes["speed"], run.time, run.velocity_b[:, :2], ("vx", "vy"), "Velocity in {b} (m/s)")
            draw_motion(axes["yaw"], run.time, run.velocity_b[:, 2:], ("omega",), "Yaw rate (rad/s)")
        for name in estimated:
            draw_doubt(axes[name], run.time, run.doubtful)
            draw_parameter(axes[name], run.time, run.parameters[name], name, legend=name == estimated[0])
        if run.wrenches:
            _draw_what_arms_did(run, axes["forces"], axes["moments"], axes["contacts"])
        for side, column in ((right, panels[:n_rows]), (left, panels[n_rows:])):
            _stack([axes[name] for name in column])
            side.align_ylabels()
    return figure


def figure_tracking(run: ShownRun) -> Figure:
    """The path beside the tracking error."""
    if run.tracking_error is None:
        raise UsageError(f"{run.name}: has no reference, so there is no tracking error to draw")
    with house_style():
        figure = Figure(figsize=(7.2, 2.8))
        path, error = figure.subplots(1, 2)
        draw_path(path, run.pose, run.reference_pose)
        draw_tracking_error(error, run.time, run.tracking_error)
    return figure


def figure_parameters(run: ShownRun) -> Figure:
    """Every estimated parameter over time."""
    if not run.parameters:
        raise UsageError(f"{run.name}: nothing was estimated in this run, so there is no estimate to draw")
    n_rows = (len(run.parameters) + 1) // 2
    with house_style():
        figure = Figure(figsize=(7.2, 1.9 * n_rows))
        axes = figure.subplots(n_rows, 2, squeeze=False).ravel()
        for ax, (name, series) in zip(axes, run.parameters.items(), strict=False):
            draw_doubt(ax, run.time, run.doubtful)
            draw_parameter(ax, run.time, series, name, legend=ax is axes[0])
        for ax in axes[len(run.parameters) :]:
            ax.remove()
        for side in (0, 1):
            _stack(list(axes[: len(run.parameters)][side::2]))
        figure.align_ylabels()
    return figure


def figure_arms(run: ShownRun) -> Figure:
    """Forces, moments and contacts of the arms over time."""
    if not run.wrenches:
        raise UsageError(f"{run.name}: nobody touches the cart, so there is no arm to draw")
    with house_style():
        figure = Figure(figsize=(5.4, 5.4))
        axes = figure.subplots(3, 1)
        _draw_what_arms_did(run, *axes)
        _stack(axes)
        figure.align_ylabels()
    return figure


def figure_log(log: RunLog, suspicions: Sequence[tuple[str, str, float]] = ()) -> Figure:
    """Path, places, headings, velocities, forces and moments; nothing is averaged. `suspicions` are kinds, where, and
    probabilities, above it."""
    run = ShownRun.of_log(log)
    panels = 3 + 2 * bool(run.wrenches)
    with house_style():
        figure = Figure(figsize=(9.0, 1.5 * panels + 0.3))
        path, right = figure.subfigures(1, 2, squeeze=False, width_ratios=(2, 3))[0]
        draw_path(path.subplots(), run.pose)
        axes = right.subplots(panels, 1, sharex=True)
        known = run.pose[np.isfinite(run.pose[:, :2]).all(axis=1), :2]
        moved = run.pose[:, :2] - (known[0] if len(known) else 0.0)
        draw_motion(axes[0], run.time, moved, ("x", "y"), "Moved (m)")
        draw_motion(axes[1], run.time, run.pose[:, 2:], ("theta",), "Heading (rad)")
        draw_motion(axes[2], run.time, run.velocity_b[:, :2], ("vx", "vy"), "Velocity in {b} (m/s)")
        if run.wrenches:
            draw_forces(axes[3], run.time, run.wrenches)
            draw_moments(axes[4], run.time, run.wrenches)
        for one in axes[:-1]:
            one.set_xlabel("")
        right.align_ylabels()
        told = [f"{kind}: {plain_text(where)} ({probability:.2f})" for kind, where, probability in suspicions]
        more = [f"and {len(told) - MAX_SUSPICIONS_SHOWN} more"] if len(told) > MAX_SUSPICIONS_SHOWN else []
        words = "suspected: " + ", ".join([*told[:MAX_SUSPICIONS_SHOWN], *more]) if told else "nothing is suspected"
        figure.suptitle(f"{plain_text(log.name, 60)}: {words}", fontsize=9, color=VERMILLION if told else "black")
    return figure


def save_figure(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Writes a figure as its suffix says: `.png` (160 dpi), `.pdf` or `.svg`."""
    kind = Path(path).suffix.lower().removeprefix(".")
    if kind not in UNDATED_METADATA:
        raise UsageError(f"{path}: figures are written as {', '.join('.' + k for k in UNDATED_METADATA)}")
    content = io.BytesIO()
    with house_style():
        figure.savefig(content, format=kind, dpi=FIGURE_DPI, metadata=UNDATED_METADATA[kind])
    return write_atomically(path, content.getvalue())


def _draw_what_arms_did(run: ShownRun, forces: Axes, moments: Axes, contacts: Axes) -> None:
    draw_forces(forces, run.time, run.wrenches)
    draw_moments(moments, run.time, run.wrenches)
    draw_contacts(contacts, run.time, run.contacts)


def _stack(column: Sequence[Axes]) -> None:
    """Axes under each other share their time; only the lowest writes it."""
    for axes in column[:-1]:
        axes.sharex(column[-1])
        axes.tick_params(labelbottom=False)
        axes.xaxis.label.set_visible(False)
