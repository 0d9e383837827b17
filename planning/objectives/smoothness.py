"""Penalises change as well: `base + sum rate weight (F - F_previous)²`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.checks import MAX_FLOAT, number
from cartgrasp.frames import Array

from .objective import Addition, Cost, Objective, WeightedWrench


@dataclass(frozen=True)
class Smoothness(Addition):
    """`rate` scales each arm's own weights: 1 makes a change as costly as the wrench itself."""

    rate: float = 1.0
    base: Objective = field(default_factory=WeightedWrench)

    def __post_init__(self) -> None:
        number("smoothness: rate", self.rate, 0.0, MAX_FLOAT)

    @property
    def looks_back(self) -> bool:
        return True

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        base = self.base.cost(arms, previous)
        added = self.rate * np.concatenate([arm.weights for arm in arms])
        n_own = len(base.weights) - len(added)
        return replace(
            base,
            weights=base.weights + np.pad(added, (0, n_own)),
            gradient=base.gradient - np.pad(2 * added * previous, (0, n_own)),
            constant=base.constant + float(added @ previous**2),
        )
