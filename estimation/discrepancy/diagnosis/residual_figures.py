"""What is left without what was added and with it, row by row: over time, over what it follows, and on the floor."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.ndimage import uniform_filter1d

from cartgrasp.frames import Array

from ..search.laws import row_values, unit_of, variable_of
from ..where.residual import Residual, fine_residuals, with_fine_rows
from ..where.residual_map import means, strongest_dependence, variables
from .drawing import BAND_STYLE, COMPARED_MODELS, MODEL_COLOURS, ZERO_LINE_STYLE, on_floor, residual_label, sides

if TYPE_CHECKING:
    from .diagnosis import Diagnosis

ResidualPair = tuple[Residual, ...]
"""What the refitted model leaves of one coordinate, and, where anything was added, what the extended one leaves."""
MAX_DRAWN_ROWS = 1500
"""Most rows of a log that is drawn row by row, else by means; and most dots."""
CLOSEUP_INTERVAL, WORST_INTERVAL, MAX_CLOSEUP_PERIODS = 10.0, 1.0, 8
"""Durations (s) of a closer look, and of the worst that it is about. Periods that it shows of what repeats in time,
where these are shorter."""
MIN_DRAWN_FRACTION = 0.3
"""Least share of the disagreement that goes along with a variable which is drawn."""
BINS_PER_PERIOD = 12
"""Bins of a period."""
CLIPPING_PERCENTILE = 99.8
"""Percentile: what is larger is cut off."""


def pairs(found: Diagnosis) -> list[tuple[ResidualPair, ResidualPair]]:
    """Residuals row by row, and in means over stretches, of the coordinates that disagree, the most first; else of the
    first."""
    models = [found.nominal, found.final] if found.effects else [found.nominal]
    fine = zip(*(fine_residuals(model, found.final) for model in models), strict=True)
    coarse = zip(*(found.before, found.after)[: len(models)], strict=True)
    every = sorted(zip(fine, coarse, strict=True), key=lambda both: -float(both[1][0].beyond.sum()))
    return [both for both in every if found.disagrees and any(one.disagrees for one in both[1])] or every[:1]


def time_figure(found: Diagnosis, shown: Sequence[tuple[ResidualPair, ResidualPair]]) -> Figure:
    """Figure with a row for each coordinate, of the log that disagrees the most, and below a closer look at the worst
    of it."""
    worst = shown[0][0][0]
    names, logs = worst.circumstances.names, worst.circumstances.log
    k = max(range(len(names)), key=lambda k: float(worst.beyond[logs == k].sum()))
    figure, axes = sides(len(shown) + 1, len(shown[0][0]), 1.6)
    for row, (fine, coarse) in zip(axes, shown, strict=False):
        _draw(row, fine if (logs == k).sum() <= MAX_DRAWN_ROWS else coarse, k)
    _draw(axes[-1], shown[0][0], k, _closeup_span(found, worst, k))
    name = f" of {Path(names[k]).name}" if len(names) > 1 else ""
    for upper, ax in zip(axes[-2], axes[-1], strict=True):
        upper.set_xlabel(f"t (s){name}")
        ax.set_xlabel(f"t (s){name}, closer")
    return figure


def _draw(axes: Sequence[Axes], pair: ResidualPair, k: int, window: tuple[float, float] = (-np.inf, np.inf)) -> None:
    for ax, residual, name in zip(axes, pair, COMPARED_MODELS, strict=False):
        own = (residual.circumstances.log == k) & (residual.start >= window[0]) & (residual.start <= window[1])
        time = residual.circumstances.time[own]
        ax.fill_between(time, -residual.std[own], residual.std[own], **BAND_STYLE)
        ax.plot(time, residual.value[own], color=MODEL_COLOURS[name], lw=0.7)
        ax.axhline(0, **ZERO_LINE_STYLE)
        ax.margins(x=0.01)
    axes[0].set_ylabel(residual_label(pair[0]))
    _cut(axes[0], pair)


def _cut(ax: Axes, pair: ResidualPair) -> None:
    top = 1.15 * max(float(np.percentile(np.abs(one.value), CLIPPING_PERCENTILE)) for one in pair)
    ax.set_ylim(-top, top)


def _closeup_span(found: Diagnosis, worst: Residual, k: int) -> tuple[float, float]:
    """Begin and end of a closer look (s): so many periods of what repeats in time, else some seconds."""
    periods = [law.period for law in (*found.final.laws, *found.withdrawn) if law.of == "time" and law.period]
    long = min(CLOSEUP_INTERVAL, MAX_CLOSEUP_PERIODS * min(periods, default=CLOSEUP_INTERVAL))
    own = worst.circumstances.log == k
    inside = max(round(WORST_INTERVAL / worst.duration), 1)
    middle = float(worst.start[own][int(np.argmax(uniform_filter1d(worst.beyond[own], inside, mode="constant")))])
    first, last = worst.start[own][[0, -1]]
    begin = float(np.clip(middle - long / 2, first, max(last - long, first)))
    return begin, begin + long


@dataclass(frozen=True)
class Dependence:
    """What a pair may follow: the variable in words, its values (b,) at the rows, and means (k,), each with what it is
    at, of the refitted and of the extended model, with standard deviations where they are known."""

    pair: ResidualPair
    words: str
    values: Array
    means: tuple[tuple[Array, Array, Array | None], ...]


def dependences(found: Diagnosis, shown: Sequence[tuple[ResidualPair, ResidualPair]]) -> Iterator[Dependence]:
    """What the disagreeing coordinates go along with (but for time, which is drawn), and what withdrawn laws that
    repeat are of."""
    maps = {(one.coordinate, one.variable): (one.refitted, one.extended) for one in found.residual_maps}
    for fine, coarse in shown:
        share, best = strongest_dependence(coarse[0], but="time")
        if found.disagrees and share > MIN_DRAWN_FRACTION and best:
            values = variables(fine[0].circumstances)[best.variable, best.unit]
            binned = tuple((one.at, one.mean, one.std) for one in maps[coarse[0].coordinate, best.variable])
            yield Dependence(fine, f"{best.variable} ({best.unit})", values, binned)
    for effect in (law.effects[0] for law in found.withdrawn if law.period):
        fine = shown[0][0]
        values = row_values(effect, with_fine_rows(found.final.logs)) % effect.cycle
        bins = np.linspace(0.0, values.max(), BINS_PER_PERIOD + 1)
        folded = tuple((*means(residual, values, bins)[:2], None) for residual in fine)
        yield Dependence(fine, f"{variable_of(effect)} ({unit_of(effect)}), folded", values, folded)


def dependence_figure(rows: Sequence[Dependence]) -> Figure:
    """Figure of rows as dots, and their means in bins."""
    figure, axes = sides(len(rows), len(rows[0].pair), 2.2)
    for one, row in zip(rows, axes, strict=True):
        every = slice(None, None, 1 + len(one.values) // MAX_DRAWN_ROWS)
        for ax, residual, (at, mean, std), name in zip(row, one.pair, one.means, COMPARED_MODELS, strict=False):
            ax.plot(one.values[every], residual.value[every], ".", ms=2, color="0.7")
            ax.errorbar(at, mean, std, fmt=".-", lw=1.0, ms=5, color=MODEL_COLOURS[name])
            ax.axhline(0, **ZERO_LINE_STYLE)
            ax.set_xlabel(one.words)
        row[0].set_ylabel(residual_label(one.pair[0]))
        _cut(row[0], one.pair)
    return figure


def floor_figure(shown: Sequence[tuple[ResidualPair, ResidualPair]]) -> Figure:
    """Figure of residuals on the floor, a row for each coordinate."""
    figure, axes = sides(len(shown), len(shown[0][1]), 2.6, sharex=True)
    for row, (_, pair) in zip(axes, shown, strict=True):
        places, values = pair[0].circumstances.covariates.place, [one.value for one in pair]
        on_floor(figure, row, places, values, residual_label(pair[0]))
    return figure
