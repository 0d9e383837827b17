"""Whether what reports say of their own certainty is so: probabilities of names, and intervals of parameters."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from .judging import Estimate, Judgement

EDGES = (0.0, 0.5, 0.8, 0.95, 0.99, 1.0)
INTERVAL = 1.96
"""Standard deviations: of 95 %."""


def coverage(groups: dict[str, Sequence[Estimate]]) -> str:
    """How many of the 95 % intervals hold the truth; of numbers that mean the same on both sides alone."""
    lines = ["95 % intervals that hold the truth"]
    for title, group in groups.items():
        z = np.array([e.z for e in group if not e.roughly])
        z = z[np.isfinite(z)]
        if len(z):
            held = int((abs(z) < INTERVAL).sum())
            lines.append(f"{title:<52} {held:>3} of {len(z):<3} {100 * held / len(z):5.1f} %   median |z| {median(z)}")
    return "\n".join(lines) if len(lines) > 1 else ""


def reliability(judgements: Sequence[Judgement]) -> str:
    """By what was said to be the probability of a name: how often it is true."""
    told = probabilities(judgements)
    if not len(told):
        return ""
    lines = [f"{'Probability of a name':<32} {'n':>4} {'mean said':>10} {'true':>7}"]
    for (low, high), said, right in bins(told):
        lines.append(f"{f'{low:g} to {high:g}':<32} {len(right):>4} {said:>10.3f} {right.mean():>7.3f}")
    lines.append(f"{'Brier score':<32} {len(told):>4} {brier(*told.T):>10.3f}")
    return "\n".join(lines)


def brier(said: np.ndarray, right: np.ndarray) -> float:
    return float(np.mean((said - right) ** 2))


def probabilities(judgements: Sequence[Judgement]) -> np.ndarray:
    """Of all names: what was said, and whether it is true (n, 2)."""
    return np.array([one for j in judgements for one in j.probabilities], dtype=float).reshape(-1, 2)


def bins(told: np.ndarray) -> list[tuple[tuple[float, float], float, np.ndarray]]:
    """Limits of each that has names, the mean that was said in it, and which of its names are true."""
    found = []
    for low, high in pairwise(EDGES):
        inside = told[(told[:, 0] > low) & (told[:, 0] <= high)]
        if len(inside):
            found.append(((low, high), float(inside[:, 0].mean()), inside[:, 1]))
    return found


def median(z: np.ndarray) -> str:
    return f"{np.median(abs(z)):.2f}"
