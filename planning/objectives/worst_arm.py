"""Spares the arm that works hardest: `base + weight t²`, t the largest share |F_ij| / limit_ij that any component of
any arm takes of its own limit. In epigraph form: one unknown more, and rows `±F_ij / limit_ij <= t`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.checks import MAX_FLOAT, positive
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from planning.limits import LimitRows

from .objective import ABOVE_ZERO, Addition, Cost, Objective, WeightedWrench

MIN_ARM_LIMIT = 1e-9  # N, N·m: what a proof takes for kept; a share of a smaller limit would be one of rounding


@dataclass(frozen=True)
class WorstArm(Addition):
    """`weight` of the squared share; components without a limit, or with one of `MIN_ARM_LIMIT` or less, have none."""

    weight: float = field(metadata=ABOVE_ZERO)
    base: Objective = field(default_factory=WeightedWrench)
    adds_unknowns = True

    def __post_init__(self) -> None:
        positive("worst arm: weight", self.weight, MAX_FLOAT, "give a share of the cost")

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        base = self.base.cost(arms, previous)
        if base.epigraph is not None:
            raise UsageError("worst arm: its base has unknowns of its own; only one of an objective's parts may")
        return replace(
            base,
            weights=np.append(base.weights, self.weight),
            gradient=np.append(base.gradient, 0.0),
            coupling=None if base.coupling is None else np.pad(base.coupling, ((0, 1), (0, 1))),
            epigraph=_shares(arms),
        )


def _shares(arms: Sequence[Arm]) -> LimitRows:
    limits = np.concatenate([arm.wrench_limit for arm in arms])
    limited = np.flatnonzero(np.isfinite(limits) & (limits > MIN_ARM_LIMIT))
    if not len(limited):
        raise UsageError(f"worst arm: none of {[arm.name for arm in arms]} has a force_limit or moment_limit to share")
    shares = np.zeros((len(limited), len(limits) + 1))
    shares[np.arange(len(limited)), limited] = 1.0 / limits[limited]
    rows = np.vstack([shares, -shares])
    rows[:, -1] = -1.0
    k = len(rows)
    return LimitRows(np.zeros(1), np.full(1, np.inf), ("",), ("",), rows, np.zeros(k), ("",) * k)
