"""Which effects a motion can show, and which of them it can tell apart, before anything is decided.

With the model's own parameters taken out, an effect of usual size stands out of the noise by z deviations. Two effects
look alike where their traces are parallel: where the largest canonical correlation of the two is near 1.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from scipy.linalg import solve_triangular

from cartgrasp.effects import Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.effects.time_delay import TimeDelay
from cartgrasp.frames import Array

from .candidates import families
from .model import Model

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


@dataclass(frozen=True, eq=False)
class Trace:
    """What an effect's amplitudes do to whitened rows, of noise 1, (n, q), and their usual sizes (q,)."""

    key: str
    columns: Array
    usual: Array


def isolability(model: Model) -> dict[str, Isolability]:
    """Of the effects that act all the time, and that the model does not have, by key."""
    scale = model.score.scale[:, None]
    base = (model.rows[..., :-1] / scale).reshape(-1, len(model.prior_std))
    return compared(base, model.prior_std**-2.0, [_trace(model, effect) for effect in _always(model)])


def _always(model: Model) -> list[Effect]:
    """But for what shifts time, which is no sum of columns."""
    arms = tuple(dict.fromkeys(arm for balances in model.logs for arm in balances.wrenches.arms))
    every = (effect for family in families(model.cart, arms) for effect in family.variants)
    return [effect for effect in every if effect.gate is Gate.ALWAYS and not isinstance(effect, TimeDelay)]


def _trace(model: Model, effect: Effect) -> Trace:
    columns, std = model.columns_of(effect)
    flat = (columns / model.score.scale[:, None]).reshape(-1, len(std))
    return Trace(effect.key, flat, std / 2)


def compared(base: Array, prior: Array, traces: Sequence[Trace]) -> dict[str, Isolability]:
    """By key; of variants, which have one key, the one that shows most. `prior` (p,) is the information about the
    amplitudes of the base's columns (n, p) beside the rows."""
    whole = np.concatenate([base, *(trace.columns for trace in traces)], axis=1)
    gram, p = whole.T @ whole, base.shape[1]
    to_base = gram[:, :p]
    reduced = gram - to_base @ np.linalg.solve(gram[:p, :p] + np.diag(prior), to_base.T)
    chosen: dict[str, tuple[np.ndarray, float]] = {}
    ends = p + np.cumsum([trace.columns.shape[1] for trace in traces], dtype=int)
    for trace, end in zip(traces, ends, strict=True):
        columns = np.arange(end - trace.columns.shape[1], end)
        squares = trace.usual**2 * np.diagonal(reduced)[columns]
        z = float(np.sqrt(max(squares.max(), 0.0)))
        if trace.key not in chosen or z > chosen[trace.key][1]:
            chosen[trace.key] = columns, z
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
