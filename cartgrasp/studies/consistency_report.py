"""The study of consistency in numbers, claims and a figure: means over the runs, and the 95 % bands of these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.stats import chi2

from estimation.prior import report_names

from ..frames import Array
from ..view.plots import OKABE_ITO, house_style
from .consistency import MATCHED_MODEL, MODELS, SQUARES, WRONG_MODEL, Trace, believed
from .estimators import CONTROL_PERIOD
from .findings import Claim, Findings, Section

MIN_INSIDE_FRACTION = 0.9
COLUMNS = ("model", "square", "by dimension, over all steps", "95 % band of a step", "steps inside")
SCORE_TIMES = (1.0, 3.0, 6.0, 12.0)
SCORE_COLUMNS = ("model", "parameter", *(f"{time:g} s" for time in SCORE_TIMES))
LOG_SCALE_RATIO = 3.0
"""Times its band: what goes higher is drawn in decades."""


@dataclass(frozen=True, eq=False)
class Consistency:
    """The mean of one square over the runs, by its dimension, at each step that has one (n,), and the band of each
    mean."""

    time: Array
    mean: Array
    low: float
    high: float

    @property
    def inside(self) -> float:
        return float(((self.mean >= self.low) & (self.mean <= self.high)).mean())


def consistency(runs: Sequence[dict[str, Trace]], model: str, square: str) -> Consistency:
    """The consistency of one model by one square, from the runs' traces by model."""
    values = np.array([run[model].squares[square] for run in runs])
    size = runs[0][model].dimensions[square]
    seen = np.isfinite(values).all(axis=0)
    low, high = (float(chi2.ppf(p, size * len(runs))) / (size * len(runs)) for p in (0.025, 0.975))
    time = CONTROL_PERIOD * np.arange(values.shape[1])
    return Consistency(time[seen], values[:, seen].mean(axis=0) / size, low, high)


def rows(runs: Sequence[dict[str, Trace]]) -> list[tuple[str, ...]]:
    """The rows of a table with COLUMNS."""
    told: list[tuple[str, ...]] = []
    for model, square in product(MODELS, SQUARES):
        found = consistency(runs, model, square)
        band = f"{found.low:.3f} to {found.high:.3f}"
        told.append((model, square, f"{found.mean.mean():.3f}", band, f"{100 * found.inside:.1f} %"))
    return told


def score_rows(runs: Sequence[dict[str, Trace]]) -> list[tuple[str, ...]]:
    """Rms errors of each model's own parameters in standard deviations, by SCORE_COLUMNS."""
    told: list[tuple[str, ...]] = []
    for model in MODELS:
        scores = np.array([run[model].scores for run in runs])
        steps = [min(round(time / CONTROL_PERIOD), scores.shape[1]) - 1 for time in SCORE_TIMES]
        rms = np.sqrt((scores[:, steps] ** 2).mean(axis=0))
        names = report_names(believed(model)[0])
        told += [(model, name, *(f"{v:.2f}" for v in rms[:, i])) for i, name in enumerate(names)]
    return told


def claims(runs: Sequence[dict[str, Trace]]) -> list[Claim]:
    """Each square in its band, and a wrong model that is not."""
    shares = {model: [consistency(runs, model, square).inside for square in SQUARES] for model in MODELS}
    words = f"in its 95 % band at {MIN_INSIDE_FRACTION:.0%} of the steps"
    told = [
        Claim(square, words, f"{share:.1%}", share >= MIN_INSIDE_FRACTION)
        for square, share in zip(SQUARES, shares[MATCHED_MODEL], strict=True)
    ]
    worst = min(shares[WRONG_MODEL])
    return [*told, Claim(WRONG_MODEL, "fails the same test", f"worst share {worst:.1%}", worst < MIN_INSIDE_FRACTION)]


def findings(runs: Sequence[dict[str, Trace]]) -> Findings:
    promised = claims(runs)
    sections = [
        Section("Normalised squares, means over the runs", COLUMNS, rows(runs), left=2),
        Section.of_claims("Claims", promised),
        Section("Parameters: rms errors in standard deviations", SCORE_COLUMNS, score_rows(runs), left=2),
    ]
    return Findings(
        "Consistency", sections, {"squares": [as_dict(runs, *one) for one in product(MODELS, SQUARES)]}, promised
    )


def as_dict(runs: Sequence[dict[str, Trace]], model: str, square: str) -> dict[str, object]:
    """The consistency as `--json` has it."""
    found = consistency(runs, model, square)
    band = [found.low, found.high]
    return {"model": model, "square": square, "mean": float(found.mean.mean()), "band": band, "inside": found.inside}


def draw_square(axes: Axes, found: Consistency) -> None:
    """The mean over the runs by its dimension, and the band that 95 % of the steps should be in."""
    axes.axhspan(found.low, found.high, color=OKABE_ITO[0], alpha=0.2, linewidth=0, label="95 % of steps")
    axes.plot(found.time, found.mean, color=OKABE_ITO[1], linewidth=0.7, label="mean over the runs")
    width, highest = found.high - found.low, float(found.mean.max())
    if highest > LOG_SCALE_RATIO * found.high:
        axes.set_yscale("log")
        axes.set_ylim(0.5 * found.low, 2 * highest)
    else:
        axes.set_ylim(found.low - 1.5 * width, max(found.high + 1.5 * width, highest + 0.2 * width))


def figure(runs: Sequence[dict[str, Trace]]) -> Figure:
    """A page: squares down, models across."""
    with house_style():
        page = Figure(figsize=(7.2, 7.2), layout="constrained")
        panels = page.subplots(len(SQUARES), len(MODELS), sharex=True)
        for row, square in zip(panels, SQUARES, strict=True):
            for axes, model in zip(row, MODELS, strict=True):
                draw_square(axes, consistency(runs, model, square))
            row[0].set_ylabel(square)
        for top, bottom, model in zip(panels[0], panels[-1], MODELS, strict=True):
            top.set_title(model)
            bottom.set_xlabel("Time (s)")
        page.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=2)
    return page
