"""How probable names are: a map from the gain at which they were added, fitted to one half of the logs of some folders,
and held against the other half, beside the map that the workflow has and a constant."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

from estimation.discrepancy.named import TRUE_AT, TRUE_BY
from estimation.discrepancy.search import WORTH

from .calibration import bins, brier
from .judging import bare
from .reliability_plot import save_reliability
from .score import judged

PRIOR = (0.0, 3.0), (1.0, 1.0)
"""Mean and standard deviation of both numbers of the map: few names are wrong."""
HEADER = "| probability said | names | mean said | true |\n| --- | --- | --- | --- |"


@dataclass(frozen=True)
class Names:
    """Of names (n,): what was said, what rivals leave of it, the log of the gain over what a name is worth (not finite
    where no step added it), whether the name is true, and in which half its log is."""

    said: np.ndarray
    left: np.ndarray
    gain: np.ndarray
    right: np.ndarray
    half: np.ndarray

    def of(self, half: int) -> Names:
        own = self.half == half
        return Names(*(column[own] for column in vars(self).values()))

    def by(self, at: float, more: float) -> np.ndarray:
        """Probabilities of a map; of what no step added, what was said."""
        known = np.isfinite(self.gain)
        return np.where(known, self.left * expit(at + more * np.where(known, self.gain, 0.0)), self.said)


def names(folders: Sequence[Path], reports: str) -> Names:
    rows: list[tuple[Any, ...]] = []
    for folder in folders:
        for truth, judgement in zip(sorted((folder / "truth").glob("*.json")), judged(folder, reports), strict=True):
            half = sha256(truth.stem.encode()).digest()[0] % 2
            known = {bare(e["name"]): e for e in reversed((judgement.report or {}).get("effects", []))}
            for (said, right), effect in zip(judgement.probabilities, known.values(), strict=True):
                gain = np.log(max(effect["gain"], 1.0) / WORTH) if effect.get("gain") else np.nan
                left = said / expit(TRUE_AT + TRUE_BY * gain) if np.isfinite(gain) else 1.0
                rows.append((said, left, gain, right, half))
    return Names(*np.array(rows, dtype=float).reshape(-1, 5).T)


def fitted(told: Names) -> tuple[float, float]:
    """By maximum posterior; the map is monotone."""

    def cost(numbers: np.ndarray) -> float:
        likely = np.clip(told.by(*numbers), 1e-9, 1 - 1e-9)
        off = sum(((n - mean) / std) ** 2 / 2 for n, (mean, std) in zip(numbers, PRIOR, strict=True))
        return float(off - np.log(np.where(told.right > 0, likely, 1 - likely)).sum())

    found = minimize(cost, [mean for mean, _ in PRIOR], bounds=[(None, None), (0.0, None)])
    return float(found.x[0]), float(found.x[1])


def reliability(folders: Sequence[Path], reports: str, figure: Path | None) -> str:
    """A table of the half that was not fitted to."""
    every = names(folders, reports)
    first, second = every.of(0), every.of(1)
    if not (len(first.said) and len(second.said)):
        return "no names with a probability in one half of the logs: give more logs"
    at, more = fitted(first)
    told = second.by(at, more)
    rows = [
        f"Fitted to {len(first.said)} names, of which {int(first.right.sum())} are true: log odds {at:.2f} at {WORTH:g}"
    ]
    rows[0] += f" nats, and {more:.2f} for each time e as many. Of the other half:"
    rows += ["", HEADER]
    for (low, high), said, right in bins(np.column_stack([told, second.right])):
        rows.append(f"| {low:g} to {high:g} | {len(right)} | {said:.3f} | {right.mean():.3f} |")
    scores = {"fitted": told, "the workflow's": second.said, "one for all": np.full(len(told), first.right.mean())}
    rows += ["", "| map | Brier score | log score, nats a name |", "| --- | --- | --- |"]
    for name, said in scores.items():
        rows.append(f"| {name} | {brier(said, second.right):.4f} | {_log_score(said, second.right):.4f} |")
    if figure is not None:
        save_reliability(np.column_stack([told, second.right]), figure)
    return "\n".join(rows)


def _log_score(said: np.ndarray, right: np.ndarray) -> float:
    return float(-np.log(np.clip(np.where(right > 0, said, 1 - said), 1e-9, None)).mean())
