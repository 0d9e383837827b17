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
from scipy.linalg import orth

from cartgrasp.effects.effect import Gate
from cartgrasp.effects.time_delay import TimeDelay
from cartgrasp.frames import Array

from ..search.candidates import families
from ..search.model import Model

CONFUSABLE_CORRELATION = 0.95
"""Canonical correlation above which two effects look alike."""
TRACE_RANK_TOLERANCE = 3e-5
"""Share of a trace's largest direction: less than that is rounding."""
SHOWN_SIGMAS = 3.0
"""Deviations by which an effect that is shown stands out at least."""


@dataclass(frozen=True)
class Isolability:
    """Deviations by which an effect of usual size stands out, and how much each other one looks like it on this motion.
    That likeness is the largest canonical correlation of their traces, by key."""

    z: float
    likeness: Mapping[str, float]

    @property
    def alike(self) -> tuple[str, ...]:
        return tuple(key for key, likeness in self.likeness.items() if likeness > CONFUSABLE_CORRELATION)

    @property
    def is_shown(self) -> bool:
        return self.z >= SHOWN_SIGMAS

    def as_dict(self) -> dict[str, Any]:
        return {"z": self.z, "alike": list(self.alike), "likeness": dict(self.likeness)}


def isolability(model: Model) -> dict[str, Isolability]:
    """Isolability, by key, of the effects that act all the time and that the model does not have. What shifts time is
    left out: it is no sum of columns."""
    scale = model.score.scale[:, None]
    base = (model.rows[..., :-1] / scale).reshape(-1, len(model.prior_std))
    arms = tuple(dict.fromkeys(arm for balances in model.logs for arm in balances.wrenches.arms))
    traces = []
    for effect in (effect for family in families(model.cart, arms) for effect in family.variants):
        if effect.gate is Gate.ALWAYS and not isinstance(effect, TimeDelay):
            columns, std = model.columns_of(effect)
            traces.append((effect.key, (columns / scale).reshape(-1, len(std)) * std / 2))
    return compared(base, model.prior_std**-2.0, traces)


def compared(base: Array, prior: Array, traces: Sequence[tuple[str, Array]]) -> dict[str, Isolability]:
    """Isolability by key; of variants, which have one key, that of the one that shows most. Traces are what effects of
    usual size do to whitened rows (n, q), of noise 1. `prior` (p,) is the information about the amplitudes of the
    base's columns (n, p) beside the rows."""
    taken = np.linalg.qr(np.vstack([base, np.diag(prior**0.5)]))[0]
    chosen: dict[str, tuple[float, Array]] = {}
    for key, columns in traces:
        whole = np.vstack([columns, np.zeros((len(prior), columns.shape[1]))])
        left = whole - taken @ (taken.T @ whole)
        z = float(np.linalg.norm(left, axis=0).max())
        if key not in chosen or z > chosen[key][0]:
            chosen[key] = z, orth(left, rcond=TRACE_RANK_TOLERANCE)
    pairs = combinations(chosen.items(), 2)
    alike = {frozenset((a, b)): _correlation(here, there) for (a, (_, here)), (b, (_, there)) in pairs}
    return {
        key: Isolability(z, {other: alike[frozenset((key, other))] for other in chosen if other != key})
        for key, (z, _) in chosen.items()
    }


def _correlation(here: Array, there: Array) -> float:
    """The largest canonical correlation of orthonormal columns; 0 where either leaves no trace."""
    return float(np.linalg.svd(here.T @ there, compute_uv=False).max(initial=0.0))
