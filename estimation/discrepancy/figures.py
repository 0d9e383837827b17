"""The figures of a report, as SVG texts."""

from __future__ import annotations

import io
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from .isolability import ALIKE

if TYPE_CHECKING:
    from .diagnosis import Diagnosis
    from .residual import Residual

NO_METADATA = dict.fromkeys(("Creator", "Date", "Format", "Type"))
BEFORE, AFTER, FLOOR = "#d55e00", "#0072b2", "#999999"
MOST_LOGS = 4
"""Whose residuals are drawn over time."""
FLAT = 0.05
"""Of its length: a way that is no wider would be a line."""


def figures(diagnosis: Diagnosis) -> dict[str, str]:
    """SVG texts by name."""
    drawn = {"gap": _gap, "residuals": _residuals, "places": _places}
    if len(diagnosis.isolability) > 1:
        drawn["isolability"] = _isolability
    plain = mpl.rc_context({"svg.hashsalt": "cartgrasp", "svg.fonttype": "none", "text.parse_math": False})
    with plain, warnings.catch_warnings():  # names come from logs: what looks like a formula is none
        warnings.filterwarnings("ignore", "Glyph")  # the reader's fonts draw it
        found = {name: _svg(draw(diagnosis), "tight") for name, draw in drawn.items()}
        return found | {"maps": _svg(_maps(diagnosis))}


def _svg(figure: Figure, box: str | None = None) -> str:
    """Cut to what is drawn, if the box is "tight", which is to draw twice."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata=NO_METADATA, bbox_inches=box)
    text = buffer.getvalue()
    return text[text.index("<svg") :]


def _gap(found: Diagnosis) -> Figure:
    figure = Figure(figsize=(7.2, 2.2))
    ax = figure.subplots()
    horizons = found.gap.per_horizon
    names = {"before": ("nominal", "#e69f00"), "refitted": ("refitted", BEFORE), "after": ("extended", AFTER)}
    names["noise_floor"] = ("noise alone", FLOOR)
    place = np.arange(len(horizons))
    for k, (key, (label, colour)) in enumerate(names.items()):
        values = [1e3 * one[key] for one in horizons.values()]
        ax.bar(place + 0.2 * (k - 1.5), values, 0.18, label=label, color=colour)
    ax.set_xticks(place, [f"after {h}" for h in horizons])
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
    figure = Figure(figsize=(7.2, 1.7 * len(found.before)))
    rows = figure.subplots(
        len(found.before), len(names), sharex="col", sharey="row", squeeze=False, gridspec_kw={"hspace": 0.15}
    )
    for axes, *both in zip(rows, found.before, found.after, strict=True):
        axes[0].set_ylabel(_named(both[0]))
        for k, ax in enumerate(axes):
            for residual, colour, label in zip(both, (BEFORE, AFTER), ("refitted", "extended"), strict=True):
                own = residual.circumstances.log == k
                ax.plot(residual.start[own], residual.value[own], ".-", lw=0.8, ms=3, color=colour, label=label)
            for change in both[0].change_times[k]:
                ax.axvline(change, color="0.4", lw=0.8, ls=":")
            ax.axhline(0, color="0.6", lw=0.6)
    for ax, name in zip(rows[-1], names, strict=True):
        ax.set_xlabel("t (s)" if len(names) == 1 else f"t (s) of {Path(name).name}")
    rows[0][0].legend(frameon=False, fontsize=8)
    return figure


def _places(found: Diagnosis) -> Figure:
    """A row for each coordinate."""
    figure = Figure(figsize=(7.2, 2.8 * len(found.before)))
    rows = figure.subplots(len(found.before), 2, sharex=True, sharey=True, squeeze=False)
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
            bar.solids.set_rasterized(False)
            bar.solids.set_edgecolor("face")
    for ax, title in zip(rows[0], ("refitted", "extended"), strict=True):
        ax.set_title(title, fontsize=9)
    for ax in rows[-1]:
        ax.set_xlabel("x (m)")
    return figure


def _maps(found: Diagnosis) -> Figure:
    """A row for each variable, a column for each coordinate."""
    maps = found.residual_maps
    variables = list(dict.fromkeys((one.variable, one.variable_unit) for one in maps))
    if not variables:
        return Figure(figsize=(8.4, 0.5))
    height = 1.6 * len(variables) + 0.5
    figure = Figure(figsize=(8.4, height))
    margins = {"left": 0.06, "right": 0.99, "top": 1 - 0.3 / height, "bottom": 0.45 / height}
    rows = figure.subplots(
        len(variables),
        len(found.before),
        sharex="row",
        sharey="col",
        squeeze=False,
        gridspec_kw={"hspace": 0.75, "wspace": 0.3, **margins},
    )
    known = {(one.variable, one.coordinate): one for one in maps}
    for axes, (variable, unit) in zip(rows, variables, strict=True):
        for ax, residual in zip(axes, found.before, strict=True):
            ax.axhline(0, color="0.6", lw=0.6)
            ax.set_xlabel(f"{variable} ({unit})", fontsize=8)
            ax.tick_params(labelsize=7)
            ax.locator_params(nbins=4)
            one = known.get((variable, residual.coordinate))
            if one is None:
                continue
            for bins, colour in ((one.refitted, BEFORE), (one.extended, AFTER)):
                ax.errorbar(one.at, bins.mean, bins.std, fmt=".-", lw=0.8, ms=4, color=colour)
    for ax, residual in zip(rows[0], found.before, strict=True):
        ax.set_title(_named(residual), fontsize=9)
    return figure


def _isolability(found: Diagnosis) -> Figure:
    """How much each effect looks like each other one; grey, where it does not show."""
    shown = found.isolability
    keys, n = list(shown), len(shown)
    likeness = np.array([[1.0 if a == b else shown[a].likeness[b] for b in keys] for a in keys])
    hidden = np.array([not shown[key].is_shown for key in keys])
    figure = Figure(figsize=(1.6 + 0.28 * n, 1.6 + 0.28 * n))
    ax = figure.subplots()
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
