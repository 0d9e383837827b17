"""The reliability diagram: what was said to be the probability of names, and how often they are true."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import beta

from .calibration import bins

LIMITS = 0.025, 0.975
BLUE = "#0072B2"


def save_reliability(told: np.ndarray, path: Path) -> None:
    """Of what was said and whether it is true (n, 2): a point for each bin of probability, with what binomial chance
    leaves open of it (Clopper and Pearson)."""
    figure = Figure(figsize=(4.2, 4.0), layout="constrained")
    axes = figure.subplots()
    axes.plot([0, 1], [0, 1], color="0.6", linestyle=":")
    for _, said, true in bins(told):
        right, count = int(true.sum()), len(true)
        low, high = beta.ppf(LIMITS, [right, right + 1], [count - right + 1, count - right])
        low, high = np.nan_to_num(low, nan=0.0), np.nan_to_num(high, nan=1.0)
        axes.plot([said, said], [low, high], color=BLUE)
        axes.plot(said, right / count, "o", color=BLUE)
        middle = (low + high) / 2
        axes.annotate(f"{count}", (said, middle), xytext=(4, 0), textcoords="offset points", va="center", fontsize=8)
    axes.set(xlim=(0, 1.05), ylim=(0, 1.02), xlabel="Probability that is said", ylabel="Share of names that are true")
    figure.savefig(path, dpi=200)
