"""How probable names are: a map from the gain at which they were added, from its share of the largest, and from whether
they close any of the gap, fitted to some logs and held against others, beside the map that the workflow has and a
constant.

    python -m benchmarks.name_probabilities DIR …
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit

from estimation.discrepancy.findings.named_effects import ALTERNATIVE_ODDS_WEIGHT, name_probability
from estimation.discrepancy.search.gains import MIN_GAIN_NATS

from .sealed.calibration import bins, brier
from .sealed.judging import bare
from .sealed.reliability_plot import save_reliability
from .sealed.score import judged

PRIOR = (0.0, 3.0), (1.0, 1.0), (1.0, 1.0), (0.0, 0.5), (0.0, 3.0)
"""Mean and standard deviation of the five numbers of the map: few names are wrong."""
HEADER = "| probability said | names | mean said | true |\n| --- | --- | --- | --- |"


@dataclass(frozen=True)
class Names:
    """Of names (n,): what was said, the odds of rivals, the logs of the gain over what a name is worth and over
    the largest gain (not finite where no step added it), whether it closes nothing of the gap, whether the name is
    true, and in which half its log is."""

    said: np.ndarray
    rivals: np.ndarray
    gain: np.ndarray
    beside: np.ndarray
    unproven: np.ndarray
    right: np.ndarray
    half: np.ndarray

    def of(self, half: int) -> Names:
        own = self.half == half
        return Names(*(column[own] for column in vars(self).values()))

    def by(self, at: float, more: float, beside: float, rival: float, unproven: float) -> np.ndarray:
        """Probabilities of a map; of what no step added, what was said."""
        odds = at + more * np.nan_to_num(self.gain) + beside * np.nan_to_num(self.beside) - unproven * self.unproven
        return np.where(np.isfinite(self.gain), expit(odds) / (1.0 + rival * self.rivals), self.said)


def names(folders: Sequence[Path], reports: str) -> Names:
    rows: list[tuple[Any, ...]] = []
    for folder in folders:
        for truth, judgement in zip(sorted((folder / "truth").glob("*.json")), judged(folder, reports), strict=True):
            half, report = sha256(truth.stem.encode()).digest()[0] % 2, judgement.report or {}
            known, first = {bare(e["name"]): e for e in reversed(report.get("effects", []))}, _largest(report)
            for (said, right), effect in zip(judgement.probabilities, known.values(), strict=True):
                gain, alone, closes = max(effect.get("gain", 0.0), 1.0), said, effect.get("gap_share", 0.0) > 0.0
                logs = np.log(gain / MIN_GAIN_NATS), np.log(gain / max(first, gain))
                if effect.get("gain"):
                    alone = name_probability(gain, first, closes)
                else:
                    logs = np.nan, np.nan
                rows.append((said, (alone / said - 1.0) / ALTERNATIVE_ODDS_WEIGHT, *logs, not closes, right, half))
    return Names(*np.array(rows, dtype=float).reshape(-1, 7).T)


def _largest(report: Mapping[str, Any]) -> float:
    """Of the gains of what steps added."""
    steps = report.get("steps", [])
    return max((c["score"] for s in steps for c in s["candidates"] if c["key"] == s["added"]), default=0.0)


def fitted(told: Names) -> tuple[float, ...]:
    """By maximum posterior; the map is monotone."""

    def cost(numbers: np.ndarray) -> float:
        likely = np.clip(told.by(*numbers), 1e-9, 1 - 1e-9)
        off = sum(((n - mean) / std) ** 2 / 2 for n, (mean, std) in zip(numbers, PRIOR, strict=True))
        return float(off - np.log(np.where(told.right > 0, likely, 1 - likely)).sum())

    found = minimize(cost, [mean for mean, _ in PRIOR], bounds=[(None, None), *[(0.0, None)] * 4])
    return tuple(found.x.tolist())


def reliability(folders: Sequence[Path], others: Sequence[Path], reports: str, figure: Path | None) -> str:
    """A table of the logs of other folders; where there are none, of one half of the logs, fitted to the other."""
    every = names(folders, reports)
    first, second = (every, names(others, reports)) if others else (every.of(0), every.of(1))
    if not (len(first.said) and len(second.said)):
        return "no names with a probability to fit to, or to judge: give more logs"
    numbers = fitted(first)
    told = second.by(*numbers)
    rows = [
        f"Fitted to {len(first.said)} names, of which {int(first.right.sum())} are true: log odds {numbers[0]:.2f} at "
        f"{MIN_GAIN_NATS:g} nats, {numbers[1]:.2f} more for each time e as many, {numbers[2]:.2f} less for each "
        f"time e that the largest gain is larger; rivals' odds count {numbers[3]:.3f} times; {numbers[4]:.2f} less "
        f"of what closes nothing. Of {len(second.said)} others:",
        "",
        HEADER,
    ]
    for (low, high), said, right in bins(np.column_stack([told, second.right])):
        rows.append(f"| {low:g} to {high:g} | {len(right)} | {said:.3f} | {right.mean():.3f} |")
    rows += ["", "| map | Brier score | log score, nats a name |", "| --- | --- | --- |"]
    scores = {"fitted": told, "the workflow's": second.said, "one for all": np.full(len(told), first.right.mean())}
    rows += [
        f"| {name} | {brier(p, second.right):.4f} | {log_score(p, second.right):.4f} |" for name, p in scores.items()
    ]
    if figure is not None:
        save_reliability(np.column_stack([told, second.right]), figure)
    return "\n".join(rows)


def log_score(said: np.ndarray, right: np.ndarray) -> float:
    return float(-np.log(np.clip(np.where(right > 0, said, 1 - said), 1e-9, None)).mean())


def main() -> None:
    parser = argparse.ArgumentParser("python -m benchmarks.name_probabilities")
    parser.add_argument("folders", type=Path, nargs="+", metavar="DIR", help="of `benchmarks.sealed`, with reports")
    parser.add_argument("--on", type=Path, nargs="+", default=[], metavar="DIR", help="fitted to all, judged on these")
    parser.add_argument("--reports", default="out", metavar="NAME", help="folder beside each log; out by default")
    parser.add_argument("--figure", type=Path, metavar="FILE", help="draw said against true probabilities there")
    options = parser.parse_args()
    print(reliability(options.folders, options.on, options.reports, options.figure))


if __name__ == "__main__":
    main()
