"""The figures of a report, as SVG texts."""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from .isolability import ALIKE
from .law_figure import law_figure

if TYPE_CHECKING:
    from .diagnosis import Diagnosis
    from .residual import Residual

NO_METADATA = dict.fromkeys(("Creator", "Date", "Format", "Type"))
LEFT = (("refitted", "#d55e00"), ("extended", "#0072b2"))
"""What two models leave: labels and colours."""
BARS = (
    ("before", "nominal", "#e69f00"),
    ("refitted", "refitted", "#d55e00"),
    ("after", "extended", "#0072b2"),
    ("noise_floor", "noise alone", "#999999"),
)
MOST_LOGS = 4
"""Whose residuals are drawn over time."""
FLAT = 0.05
"""Of its length: a way that is no wider would be a line."""


def figures(diagnosis: Diagnosis) -> dict[str, str]:
    """SVG texts by name."""
    drawn = {"gap": _gap, "residuals": _residuals, "places": _places}
    if len(diagnosis.isolability) > 1:
        drawn["isolability"] = _isolability
    if diagnosis.final.laws:
        drawn["laws"] = law_figure
    plain = mpl.rc_context({"svg.hashsalt": "cartgrasp", "svg.fonttype": "none", "text.parse_math": False})
    with plain, warnings.catch_warnings():  # names come from logs: what looks like a formula is none
        warnings.filterwarnings("ignore", "Glyph")  # the reader's fonts draw it
        found = {name: _svg(draw(diagnosis), "tight") for name, draw in drawn.items()}
        return found | ({"maps": _svg(_maps(diagnosis))} if diagnosis.residual_maps else {})


def _svg(figure: Figure, box: str | None = None) -> str:
    """Cut to what is drawn, if the box is "tight", which is to draw twice."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata=NO_METADATA, bbox_inches=box)
    text = buffer.getvalue()
    return text[text.index("<svg") :]


def _grid(rows: int, columns: int, size: tuple[float, float], **shared: Any) -> tuple[Figure, np.ndarray]:
    """Axes (rows, columns) on a figure so wide and high (inches)."""
    figure = Figure(figsize=size)
    return figure, figure.subplots(rows, columns, squeeze=False, **shared)


def _gap(found: Diagnosis) -> Figure:
    figure, ((ax,),) = _grid(1, 1, (7.2, 2.2))
    horizons = found.gap.per_horizon
    for k, (key, label, colour) in enumerate(BARS):
        values = [1e3 * one[key] for one in horizons.values()]
        ax.bar(np.arange(len(horizons)) + 0.2 * (k - 1.5), values, 0.18, label=label, color=colour)
    ax.set_xticks(np.arange(len(horizons)), [f"after {h}" for h in horizons])
    if any(0 < value < np.inf for one in horizons.values() for value in one.values()):
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_minor_formatter(NullFormatter())
    ax.set_ylabel("rollout error (mm)")
    ax.legend(frameon=False, ncols=2, fontsize=8)
    return figure


def _residuals(found: Diagnosis) -> Figure:
    """A row for each coordinate, a column for each log."""
    names = found.before[0].circumstances.names[:MOST_LOGS]
    n, near = len(found.before), {"hspace": 0.15}
    figure, rows = _grid(n, len(names), (7.2, 1.7 * n), sharex="col", sharey="row", gridspec_kw=near)
    for axes, *both in zip(rows, found.before, found.after, strict=True):
        axes[0].set_ylabel(_named(both[0]))
        for k, ax in enumerate(axes):
            for residual, (label, colour) in zip(both, LEFT, strict=True):
                own = residual.circumstances.log == k
                ax.plot(residual.start[own], residual.value[own], ".-", lw=0.8, ms=3, color=colour, label=label)
            starts = both[0].start[both[0].circumstances.log == k]
            for change in both[0].changes[k]:
                ax.axvline(starts[change], color="0.4", lw=0.8, ls=":")
            ax.axhline(0, color="0.6", lw=0.6)
    for ax, name in zip(rows[-1], names, strict=True):
        ax.set_xlabel("t (s)" if len(names) == 1 else f"t (s) of {Path(name).name}")
    rows[0][0].legend(frameon=False, fontsize=8)
    return figure


def _places(found: Diagnosis) -> Figure:
    """A row for each coordinate."""
    figure, rows = _grid(len(found.before), 2, (7.2, 2.8 * len(found.before)), sharex=True, sharey=True)
    for axes, *both in zip(rows, found.before, found.after, strict=True):
        top = max(float(np.abs(both[0].value).max()), 1e-9)
        for ax, residual in zip(axes, both, strict=True):
            place = residual.circumstances.course.place.T
            shown = ax.scatter(*place, c=residual.value, s=14, cmap="PuOr", vmin=-top, vmax=top)
            if min(np.ptp(place, axis=1)) > FLAT * max(np.ptp(place, axis=1)):
                ax.set_aspect("equal")
        axes[0].set_ylabel("y (m)")
        bar = figure.colorbar(shown, ax=axes, label=_named(both[0]))
        if bar.solids is not None:  # a page that loads nothing shows no images either
            bar.solids.set(rasterized=False, edgecolor="face")
    for top_ax, ax, (title, _) in zip(rows[0], rows[-1], LEFT, strict=True):
        top_ax.set_title(title, fontsize=9)
        ax.set_xlabel("x (m)")
    return figure


def _maps(found: Diagnosis) -> Figure:
    """A row for each variable, a column for each coordinate."""
    known = {(one.variable, one.coordinate): one for one in found.residual_maps}
    units = {one.variable: one.refitted.unit for one in found.residual_maps}
    n, height = len(units), 1.6 * len(units) + 0.5
    margins = {"left": 0.06, "right": 0.99, "top": 1 - 0.3 / height, "bottom": 0.45 / height}
    apart = {"hspace": 0.75, "wspace": 0.3, **margins}
    figure, rows = _grid(n, len(found.before), (8.4, height), sharex="row", sharey="col", gridspec_kw=apart)
    for axes, (variable, unit) in zip(rows, units.items(), strict=True):
        for ax, residual in zip(axes, found.before, strict=True):
            ax.axhline(0, color="0.6", lw=0.6)
            ax.set_xlabel(f"{variable} ({unit})", fontsize=8)
            ax.tick_params(labelsize=7)
            ax.locator_params(nbins=4)
            if one := known.get((variable, residual.coordinate)):
                for bins, (_, colour) in zip((one.refitted, one.extended), LEFT, strict=True):
                    ax.errorbar(one.refitted.at, bins.mean, bins.std, fmt=".-", lw=0.8, ms=4, color=colour)
    for ax, residual in zip(rows[0], found.before, strict=True):
        ax.set_title(_named(residual), fontsize=9)
    return figure


def _isolability(found: Diagnosis) -> Figure:
    """How much each effect looks like each other one; grey, where it does not show."""
    shown = found.isolability
    keys, n = list(shown), len(shown)
    likeness = np.array([[1.0 if a == b else shown[a].likeness[b] for b in keys] for a in keys])
    hidden = np.array([not shown[key].is_shown for key in keys])
    figure, ((ax,),) = _grid(1, 1, (1.6 + 0.28 * n, 1.6 + 0.28 * n))
    colours = mpl.colormaps["Blues"].with_extremes(bad="0.85")
    values = np.ma.masked_array(likeness, hidden[:, None] | hidden)
    ax.pcolormesh(values, cmap=colours, vmin=0, vmax=1, edgecolors="white", linewidth=0.5)
    for i, j in np.argwhere((likeness > ALIKE) & ~np.eye(n, dtype=bool) & ~values.mask):
        ax.text(j + 0.5, i + 0.5, "=", ha="center", va="center", color="white", fontsize=8)
    ax.set_yticks(np.arange(n) + 0.5, [f"{key} ({shown[key].z:.0f})" for key in keys], fontsize=7)
    ax.set_xticks(np.arange(n) + 0.5, keys, rotation=60, ha="right", rotation_mode="anchor", fontsize=7)
    ax.set_aspect("equal")
    ax.invert_yaxis()
    return figure


def _named(residual: Residual) -> str:
    return f"{residual.coordinate.replace('_', ' ')} ({residual.unit})"
