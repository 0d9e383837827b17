"""The figures of a report, as SVG texts."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from .drawing import MODEL_COLOURS, grid, is_flat, svg
from .law_figure import law_figure
from .residual_figures import dependence_figure, dependences, floor_figure, pairs, time_figure
from .rollout_figure import rollout_figure

if TYPE_CHECKING:
    from .diagnosis import Diagnosis

GAP_BARS = {"before": "nominal", "refitted": "refitted", "after": "extended", "noise_floor": "noise alone"}


def figures(diagnosis: Diagnosis) -> dict[str, str]:
    """SVG texts by name, of what there is to draw."""
    plain = mpl.rc_context({"svg.hashsalt": "cartgrasp", "svg.fonttype": "none", "text.parse_math": False})
    with plain, warnings.catch_warnings():  # names come from logs: what looks like a formula is none
        warnings.filterwarnings("ignore", "Glyph")  # the reader's fonts draw it
        return {name: svg(figure) for name, figure in _drawn(diagnosis) if figure is not None}


def _drawn(found: Diagnosis) -> Iterator[tuple[str, Figure | None]]:
    shown = pairs(found)
    yield "residuals", time_figure(found, shown)
    if rows := list(dependences(found, shown)):
        yield "follows", dependence_figure(rows)
    if found.final.laws:
        yield "laws", law_figure(found)
    if found.disagrees and not is_flat(shown[0][0][0].circumstances.covariates.place):
        yield "places", floor_figure(shown)
    yield "rollouts", rollout_figure(found)
    yield "gap", _gap(found)


def _gap(found: Diagnosis) -> Figure:
    figure, ((ax,),) = grid(1, 1, 2.0)
    horizons = found.gap.per_horizon
    bars = [(key, label) for key, label in GAP_BARS.items() if found.effects or key != "after"]
    for k, (key, label) in enumerate(bars):
        values = [1e3 * one[key] for one in horizons.values()]
        ax.bar(np.arange(len(horizons)) + 0.2 * (k - 1.5), values, 0.18, label=label, color=MODEL_COLOURS[label])
    ax.set_xticks(np.arange(len(horizons)), [f"after {h}" for h in horizons])
    if any(0 < value < np.inf for one in horizons.values() for value in one.values()):
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_minor_formatter(NullFormatter())
    ax.set_ylabel("rollout error (mm)")
    ax.legend(frameon=False, ncols=2, fontsize=8)
    return figure
