"""Figures of what arms can give: shadows of wrench polytopes, and how much of a push they give where."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, LogNorm

from ..errors import UsageError
from ..frames import Array
from .plots import BLACK, BLUE, REFERENCE_COLOUR, plain_text

INFEASIBLE_COLOUR = "#EBA27B"
"""Vermillion, light enough to write on."""


def draw_wrench_shadow(
    axes: Axes, vertices: Array, components: Sequence[str], *, label: str = "", color: str = BLUE
) -> list[Artist]:
    """A polygon of vertices (n, 2), in order, over two components (`fx` … `tz`)."""
    if len(components) != 2 or np.shape(vertices)[1:] != (2,):
        raise UsageError(f"wrench shadow: vertices {np.shape(vertices)} of {len(components)} components: 2 are drawn")
    x, y = np.asarray(vertices).T
    artists: list[Artist] = list(axes.fill(x, y, facecolor=color, alpha=0.25, label=plain_text(label)))
    artists += axes.fill(x, y, facecolor="none", edgecolor=color)
    axes.set(xlabel=_with_unit(components[0]), ylabel=_with_unit(components[1]))
    return artists


def draw_push_map(axes: Axes, standoffs: Array, heights: Array, multiples: Array, most: float = 15.0) -> list[Artist]:
    """How many times a push can be given, (heights, standoffs), written into each cell: blue where it can, the darker
    the more (up to `most`), vermillion and bold where it can't (below 1), hatched where it is NaN, out of reach."""
    can, cannot = np.ma.masked_less(multiples, 1.0), np.ma.masked_greater_equal(multiples, 1.0)
    artists: list[Artist] = [
        axes.pcolormesh(standoffs, heights, np.ma.masked_invalid(can), norm=LogNorm(0.5, 3 * most), cmap="Blues"),
        axes.pcolormesh(standoffs, heights, np.ma.masked_invalid(cannot), cmap=ListedColormap([INFEASIBLE_COLOUR])),
    ]
    for (row, column), multiple in np.ndenumerate(multiples):
        if np.isfinite(multiple):
            words, weight = (f"{multiple:.1f}", "normal") if multiple >= 1 else (f"{multiple:.2f}", "bold")
            x, y = float(standoffs[column]), float(heights[row])
            artists.append(axes.text(x, y, words, ha="center", va="center", size=7.5, weight=weight))
    axes.patch.set(hatch="////", facecolor="white", edgecolor="#DDDDDD")
    axes.grid(visible=False)
    axes.set(xlabel="Arms' bases behind the handle (m)", ylabel="Contact height (m)")
    return artists


def draw_needed_push(axes: Axes, force: float) -> list[Artist]:
    """A dashed line at the fx, N, that one arm has to give."""
    line = axes.axvline(force, color=BLACK, linestyle="--", linewidth=0.9, label="needed")
    axes.axhline(0.0, color=REFERENCE_COLOUR, linewidth=0.5)
    return [line]


def _with_unit(component: str) -> str:
    return f"{plain_text(component)} ({'N' if component.startswith('f') else 'N·m'})"
