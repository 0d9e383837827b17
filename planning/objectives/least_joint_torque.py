"""Penalises what the joints bear: `base + weight sum_i ‖J_iᵀ F_i + tau_0i‖²`, over arms that state their joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.checks import MAX_FLOAT, number
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array

from .objective import Addition, Cost, Objective, WeightedWrench


@dataclass(frozen=True)
class LeastJointTorque(Addition):
    """`weight` per (N·m)²."""

    weight: float = 1.0
    base: Objective = field(default_factory=WeightedWrench)

    def __post_init__(self) -> None:
        number("least joint torque: weight", self.weight, 0.0, MAX_FLOAT)

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        if all(arm.joints is None for arm in arms):
            raise UsageError(f"least joint torque: none of {[arm.name for arm in arms]} states its joints")
        base = self.base.cost(arms, previous)
        n = len(base.weights)
        coupling, gradient, constant = np.zeros((n, n)), base.gradient.copy(), base.constant
        for i, arm in enumerate(arms):
            if arm.joints is not None:
                own, jacobian, gravity = slice(6 * i, 6 * i + 6), arm.joints.jacobian, arm.joints.gravity_torque
                coupling[own, own] = self.weight * jacobian @ jacobian.T
                gradient[own] += 2 * self.weight * jacobian @ gravity
                constant += self.weight * float(gravity @ gravity)
        return replace(base.coupled(coupling), gradient=gradient, constant=constant)
