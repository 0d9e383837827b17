"""A log as it was recorded, row by row, with what is suspected of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from ..frames import Array
from ..logs.run_log import RunLog
from .plots import VERMILLION, draw_forces, draw_moments, draw_motion, draw_path, house_style, plain_text
from .shown_run import ShownRun

MAX_SUSPICIONS_SHOWN = 6
"""Suspicions in the title."""


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
        moved = run.pose[:, :2] - _first(run.pose[:, :2])
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


def _first(rows: Array) -> Array:
    """The first whole row (k,) of (n, k); zeros where there is none."""
    whole = np.flatnonzero(np.isfinite(rows).all(axis=1))
    return rows[whole[0]] if len(whole) else np.zeros(rows.shape[1])
