"""Which effects a motion can show, and which of them it can tell apart, before anything is decided.

With the base's parameters taken out, an effect of usual size stands out of the noise by z deviations. Two effects look
alike where their traces are parallel: where the largest canonical correlation of the two is near 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations, groupby
from typing import Any

import numpy as np
from scipy.linalg import solve_triangular

from cartgrasp.effects.effect import Gate
from cartgrasp.frames import Array

from .dictionary import Dictionary
from .evidence import Base

ALIKE = 0.95
"""Canonical correlation."""
SHOWN = 3.0
"""Deviations."""


@dataclass(frozen=True)
class Isolability:
    """By how many deviations an effect of usual size stands out, and how much each other one looks like it on this
    motion: the largest canonical correlation of their traces, by key."""

    z: float
    likeness: Mapping[str, float]

    @property
    def alike(self) -> tuple[str, ...]:
        return tuple(key for key, likeness in self.likeness.items() if likeness > ALIKE)

    @property
    def is_shown(self) -> bool:
        return self.z >= SHOWN

    def as_dict(self) -> dict[str, Any]:
        return {"z": self.z, "alike": list(self.alike), "likeness": dict(self.likeness)}


def isolability(dictionary: Dictionary, base: Base) -> dict[str, Isolability]:
    """Of the effects that act all the time, by key."""
    whole, own = dictionary.gram.sum(axis=0) / base.excess, dictionary.base
    to_base = whole[:, own]
    reduced = whole - to_base @ np.linalg.solve(whole[own, own] + base.information, to_base.T)
    chosen: dict[str, tuple[np.ndarray, float]] = {}
    always = (trial for trial in dictionary.trials if trial.effect.gate is Gate.ALWAYS)
    for key, group in groupby(always, key=lambda trial: trial.effect.key):
        sizes = []
        for trial in group:
            usual = trial.std / 2
            part = reduced[np.ix_(trial.columns, trial.columns)]
            sizes.append((trial.columns, float(np.sqrt(max((usual**2 * np.diagonal(part)).max(), 0.0)))))
        chosen[key] = max(sizes, key=lambda one: one[1])
    pairs = combinations(chosen.items(), 2)
    alike = {frozenset((a, b)): _correlation(reduced, here, there) for (a, (here, _)), (b, (there, _)) in pairs}
    return {
        key: Isolability(z, {other: alike[frozenset((key, other))] for other in chosen if other != key})
        for key, (_, z) in chosen.items()
    }


def _correlation(reduced: Array, here: np.ndarray, there: np.ndarray) -> float:
    """The largest canonical one; 0 where either leaves no trace."""
    roots = [_root(reduced[np.ix_(c, c)]) for c in (here, there)]
    if roots[0] is None or roots[1] is None:
        return 0.0
    across = solve_triangular(roots[0], reduced[np.ix_(here, there)], lower=True)
    across = solve_triangular(roots[1], across.T, lower=True)
    return float(np.linalg.svd(across, compute_uv=False).max(initial=0.0))


def _root(part: Array) -> Array | None:
    try:
        return np.asarray(np.linalg.cholesky(part + 1e-9 * np.trace(part) * np.eye(len(part))))
    except np.linalg.LinAlgError:
        return None
