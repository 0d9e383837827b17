"""Penalises hands that work against each other along a handle: `base + weight sum_i (a_i - mean a)²`, with a_i the
force of hand i along `axis` in {b}, N. See `planning.limits.internal_force`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from cartgrasp.arms import Arm
from cartgrasp.checks import MAX_FLOAT, number
from cartgrasp.frames import Array
from planning.limits.internal_force import HANDLE_AXIS_B, departures_along, direction_b

from .objective import Addition, Cost, Objective, WeightedWrench


@dataclass(frozen=True)
class LeastInternalForce(Addition):
    """`weight` per N²."""

    weight: float = 1.0
    axis: tuple[float, float, float] = HANDLE_AXIS_B
    base: Objective = field(default_factory=WeightedWrench)

    def __post_init__(self) -> None:
        number("least internal force: weight", self.weight, 0.0, MAX_FLOAT)
        object.__setattr__(self, "axis", direction_b("least internal force: axis", self.axis))

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        departures = departures_along(self.axis, arms).reshape(len(arms), -1)
        return self.base.cost(arms, previous).coupled(self.weight * departures.T @ departures)
