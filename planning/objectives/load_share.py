"""Penalises departure from stated shares of the load: `base + weight sum_i ‖f_i - share_i sum_j f_j‖²`,
with f_i the horizontal force of arm i in {b}, N."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.checks import MAX_FLOAT, check_kind, number
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array, rotation_planar

from .objective import Addition, Cost, Objective, WeightedWrench


@dataclass(frozen=True)
class LoadShare(Addition):
    """Shares by arm name; they are >= 0 and add up to 1."""

    shares: Mapping[str, float]
    weight: float = 1.0
    base: Objective = field(default_factory=WeightedWrench)

    def __post_init__(self) -> None:
        check_kind("load share: shares", self.shares, Mapping, "write {'left': 0.7, 'right': 0.3}")
        shares = [number(f"load share: {arm}", share, 0.0, 1.0) for arm, share in self.shares.items()]
        if not (shares and abs(sum(shares) - 1) <= 1e-9):
            raise UsageError(f"load share: {dict(self.shares)} are not shares >= 0 that add up to 1")
        number("load share: weight", self.weight, 0.0, MAX_FLOAT)

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        if {arm.name for arm in arms} != set(self.shares):
            raise UsageError(f"load share: shares of {sorted(self.shares)}, arms {sorted(a.name for a in arms)}")
        forces = np.zeros((len(arms), 2, 6 * len(arms)))  # f_i = forces[i] @ F
        for i, arm in enumerate(arms):
            forces[i, :, 6 * i : 6 * i + 2] = rotation_planar(arm.yaw)
        shares = np.array([self.shares[arm.name] for arm in arms])
        departure = (forces - shares[:, None, None] * forces.sum(axis=0)).reshape(-1, 6 * len(arms))
        return self.base.cost(arms, previous).coupled(self.weight * departure.T @ departure)
