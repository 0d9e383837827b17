"""Figures for a paper: each function draws one thing into the `Axes` it is given and returns the artists.

Time is in s, the unit stands on every axis, and the colour-blind can tell the colours (Okabe and Ito) apart.
An estimate is purple, its truth black and dashed, what was driven green, a reference grey and dashed.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, Literal

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from ..contacts import WRENCH_NAMES
from ..errors import UsageError
from ..frames import Array
from ..simulation.record import Series
from .player_data import PARAMETER_LABELS

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILLION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
OKABE_ITO = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, YELLOW, BLACK)
REFERENCE_COLOUR = "#7A7A7A"
MOTION_COLOURS = (GREEN, VERMILLION, BLUE)

ARM_MARKERS = ("o", "s", "^", "D")
COMPONENT_STYLES: tuple[Literal["-", "--", ":"], ...] = ("-", "--", ":")

STYLE: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.size": 8.5,
    "axes.labelsize": 8.5,
    "axes.titlesize": 9,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "legend.handlelength": 1.8,
    "legend.borderaxespad": 0.3,
    "axes.linewidth": 0.6,
    "axes.edgecolor": "#444444",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.xmargin": 0.01,
    "axes.formatter.useoffset": False,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.5,
    "lines.linewidth": 1.2,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "figure.constrained_layout.use": True,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": "cartgrasp",
}


@contextmanager
def house_style() -> Iterator[None]:
    """Figures made inside look like ours; afterwards matplotlib is as it was. A name from a log may use letters that
    the font lacks: a box is drawn for them, which is enough."""
    with mpl.rc_context(STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph", category=UserWarning)
        yield


def draw_tracking_error(axes: Axes, time: Array, error: Array) -> list[Artist]:
    """Distance from the reference, given in m and drawn in cm."""
    artists: list[Artist] = list(axes.plot(time, 100.0 * np.asarray(error), color=GREEN))
    axes.set(xlabel="Time (s)", ylabel="Tracking error (cm)")
    axes.set_ylim(bottom=0.0)
    return artists


def draw_parameter(axes: Axes, time: Array, series: Series, name: str, legend: bool = True) -> list[Artist]:
    """An estimate with its band of ± one standard deviation, and its truth where known."""
    value, band = np.asarray(series.value), np.asarray(series.std)
    artists: list[Artist] = [
        axes.fill_between(time, value - band, value + band, color=PURPLE, alpha=0.25, linewidth=0, label="± one sd"),
        *axes.plot(time, value, color=PURPLE, label="estimate"),
    ]
    truth = None if series.truth is None else np.broadcast_to(series.truth, value.shape)
    if truth is not None:
        artists += axes.plot(time, truth, color=BLACK, linestyle="--", linewidth=0.9, label="truth")
    axes.set(xlabel="Time (s)", ylabel=_parameter_label(name, series.unit))
    _limit_to_lines(axes, [value] if truth is None else [value, truth], value - band, value + band)
    if legend:
        legend_above(axes)
    return artists


def draw_doubt(axes: Axes, time: Array, doubtful: np.ndarray) -> list[Artist]:
    """Ground where (n,) an estimate says of itself that it is not as it should be."""
    if not doubtful.any():
        return []
    across = axes.get_xaxis_transform()
    colours: Any = {"color": VERMILLION, "alpha": 0.12, "linewidth": 0, "label": "health not ok"}
    return [axes.fill_between(time, 0.0, 1.0, where=doubtful.tolist(), transform=across, **colours)]


def draw_motion(axes: Axes, time: Array, columns: Array, names: Sequence[str], label: str) -> list[Artist]:
    """Columns (n, k) of poses or velocities, each with a colour and a line style; `label` is the axis's, with unit."""
    artists: list[Artist] = []
    for i, (column, name) in enumerate(zip(np.asarray(columns).T, names, strict=True)):
        artists += axes.plot(time, column, color=MOTION_COLOURS[i], linestyle=COMPONENT_STYLES[i], label=name)
    axes.set(xlabel="Time (s)", ylabel=label)
    if len(names) > 1:
        legend_above(axes)
    return artists


def draw_path(axes: Axes, pose: Array, reference_pose: Array | None = None) -> list[Artist]:
    """Reference and driven path of {b}'s origin in {s}, on equal scales; the ring marks the start."""
    artists: list[Artist] = []
    if reference_pose is not None:
        artists += axes.plot(*reference_pose[:, :2].T, color=REFERENCE_COLOUR, linestyle="--", label="reference")
    artists += axes.plot(*pose[:, :2].T, color=GREEN, label="driven")
    artists += axes.plot(*pose[:1, :2].T, color=GREEN, marker="o", markerfacecolor="white", linestyle="none")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x (m)", ylabel="y (m)")
    legend_above(axes)
    return artists


def draw_wrenches(axes: Axes, time: Array, wrenches: Mapping[str, Array], components: Sequence[str]) -> list[Artist]:
    """Components (`fx` … `tz`) of wrenches (n, 6), a colour and mark for each arm, a line style for each component."""
    unknown = [c for c in components if c not in WRENCH_NAMES]
    if unknown or len({c[0] for c in components}) != 1:
        raise UsageError(f"components: {', '.join(components)}: give some of fx, fy, fz, or some of tx, ty, tz")
    columns = {arm: np.asarray(w)[:, [WRENCH_NAMES.index(c) for c in components]] for arm, w in wrenches.items()}
    is_force = components[0].startswith("f")
    artists = _draw_arms(axes, time, columns, components)
    axes.set(xlabel="Time (s)", ylabel="Force (N)" if is_force else "Moment (N·m)")
    return artists


def draw_forces(axes: Axes, time: Array, wrenches: Mapping[str, Array]) -> list[Artist]:
    """Horizontal forces of each arm on the cart, in {a}."""
    return draw_wrenches(axes, time, wrenches, ("fx", "fy"))


def draw_moments(axes: Axes, time: Array, wrenches: Mapping[str, Array]) -> list[Artist]:
    """Moment of each arm on the cart about the vertical, in {a}."""
    return draw_wrenches(axes, time, wrenches, ("tz",))


def draw_contacts(axes: Axes, time: Array, contacts: Mapping[str, Array]) -> list[Artist]:
    """Where each arm holds the cart: x and y of contact points (n, 3) in {b}."""
    columns = {arm: np.asarray(points)[:, :2] for arm, points in contacts.items()}
    artists = _draw_arms(axes, time, columns, ("x", "y"))
    axes.set(xlabel="Time (s)", ylabel="Contact in {b} (m)")
    return artists


def plain_text(text: str, most: int = 24) -> str:
    """Any text as a label shows it letter by letter: no mathematics, no control characters, not too long."""
    shown = "".join(c if c.isprintable() else "\ufffd" for c in text)
    shown = shown if len(shown) <= most else shown[: most - 1] + "…"
    return (" " if shown.startswith("_") else "") + shown.replace("$", r"\$")


def _draw_arms(axes: Axes, time: Array, columns: Mapping[str, Array], components: Sequence[str]) -> list[Artist]:
    """Lines of (n, components) for each arm, each arm's thinner than the last: where arms do the same, all show."""
    artists: list[Artist] = []
    handles = []
    for i, (arm, values) in enumerate(columns.items()):
        marked = (len(time) // 30 * (1 + i), max(len(time) // 8, 1))
        colour, mark = OKABE_ITO[i % len(OKABE_ITO)], ARM_MARKERS[i % len(ARM_MARKERS)]
        look: dict[str, Any] = {"color": colour, "marker": mark, "markersize": 3.5, "linewidth": 2.4 / (1 + i)}
        for column, line_style in zip(values.T, COMPONENT_STYLES, strict=False):
            artists += axes.plot(time, column, linestyle=line_style, markevery=marked, **look)
        handles.append(Line2D([], [], color=colour, marker=mark, markersize=3.5, label=plain_text(arm, 14)))
    for component, line_style in zip(components, COMPONENT_STYLES, strict=False):
        handles.append(Line2D([], [], color="#555555", linestyle=line_style, label=component))
    legend_above(axes, handles)
    return artists


def _parameter_label(name: str, unit: str) -> str:
    """A quantity of the cart by its name; a parameter of an effect below the effect."""
    effect, _, parameter = name.rpartition(".")
    below = f"{plain_text(effect)}\n{plain_text(parameter)}" if effect else plain_text(name)
    label = PARAMETER_LABELS.get(name, below)
    return f"{label} ({'–' if unit in ('', '-') else plain_text(unit)})"


def legend_above(axes: Axes, handles: Sequence[Artist] | None = None) -> None:
    """Above the axes, where it hides nothing, in as many columns as fit half a page."""
    handles = axes.get_legend_handles_labels()[0] if handles is None else list(handles)
    longest = max(len(str(handle.get_label())) for handle in handles)
    axes.legend(
        handles=handles,
        loc="lower left",
        bbox_to_anchor=(0.0, 1.0),
        ncols=int(np.clip(48 // (longest + 5), 1, 6)),
        columnspacing=1.2,
    )


def _limit_to_lines(axes: Axes, lines: Sequence[Array], *edges: Array) -> None:
    """Shows the lines whole, and of the band what is not only its wide beginning."""
    finite = [part[np.isfinite(part)] for part in (*lines, *edges)]
    kept = [part for part in finite[: len(lines)] if part.size]
    kept += [np.quantile(part, [0.05, 0.95]) for part in finite[len(lines) :] if part.size]
    if kept:
        low, high = float(np.concatenate(kept).min()), float(np.concatenate(kept).max())
        room = 0.08 * (high - low) or 0.05 * abs(high) or 1.0
        axes.set_ylim(low - room, high + room)
