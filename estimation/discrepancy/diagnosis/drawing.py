"""What the figures of a report have in common."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..where.residual import Residual

NO_METADATA = dict.fromkeys(("Creator", "Date", "Format", "Type"))
MODEL_COLOURS = {
    "measured": "0.25",
    "nominal": "#e69f00",
    "refitted": "#d55e00",
    "extended": "#0072b2",
    "noise alone": "#999999",
}
"""Colours of what is measured, of three models, and of what noise does."""
COMPARED_MODELS = ("refitted", "extended")
"""Models beside one another: without what was added, and with it."""
BAND_STYLE: dict[str, Any] = {"color": "0.85", "lw": 0}
ZERO_LINE_STYLE: dict[str, Any] = {"color": "0.6", "lw": 0.6}
FLAT_PATH_RATIO = 0.05
"""Width of a path as a share of its length: one that is no wider would be a line."""


def svg(figure: Figure) -> str:
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata=NO_METADATA)
    text = buffer.getvalue()
    return text[text.index("<svg") :]


def grid(rows: int, columns: int, height: float, **shared: Any) -> tuple[Figure, np.ndarray]:
    """Axes (rows, columns) of such heights on a figure (inches)."""
    figure = Figure(figsize=(9.4, height * rows + 0.4), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **shared)
    for ax in axes.ravel():
        ax.tick_params(labelsize=7)
        ax.xaxis.label.set_fontsize(8)
        ax.yaxis.label.set_size(8)
    return figure, axes


def sides(rows: int, columns: int, height: float, **shared: Any) -> tuple[Figure, np.ndarray]:
    """Axes in rows of one scale each, for both models, or the first alone."""
    figure, axes = grid(rows, columns, height, sharey="row", **shared)
    for ax, name in zip(axes[0], COMPARED_MODELS, strict=False):
        ax.set_title(name, fontsize=9, color=MODEL_COLOURS[name])
    return figure, axes


def on_floor(figure: Figure, axes: np.ndarray, places: np.ndarray, values: list[np.ndarray], label: str) -> None:
    """Values (n,), one for each of some axes, in colours at places (n, 2), with a bar that tells them."""
    top = max(float(np.abs(values[0]).max()), 1e-9)
    for ax, value in zip(axes, values, strict=True):
        shown = ax.scatter(*places.T, c=value, s=10, cmap="PuOr", vmin=-top, vmax=top)
        ax.set_xlabel("x (m)")
        ax.set_aspect("auto" if is_flat(places) else "equal")
    axes[0].set_ylabel("y (m)")
    bar = figure.colorbar(shown, ax=axes.tolist(), label=label)
    bar.ax.tick_params(labelsize=7)
    bar.ax.yaxis.label.set_fontsize(8)
    if bar.solids is not None:  # a page that loads nothing shows no images either
        bar.solids.set(rasterized=False, edgecolor="face")


def is_flat(places: np.ndarray) -> bool:
    """Whether places (n, 2) lie on a line along x or y."""
    wide = np.ptp(places, axis=0)
    return bool(min(wide) <= FLAT_PATH_RATIO * max(wide))


def residual_label(residual: Residual) -> str:
    return f"{residual.coordinate.replace('_', ' ')} ({residual.unit})"
