"""Spares the fixed wheels: `base + weight lambda²`, lambda (N) being what the floor gives them sideways.

For what is asked of the cart, lambda is what they take of hands without any force across them, less the hands' force
across. The first part changes with the wrench, the cart and its motion: the planner fills it in at each tick
(`AllocationTemplate.cost`). A relaxed plan weighs lambda as if all that was asked were given.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from cartgrasp.arms import Arm
from cartgrasp.checks import MAX_FLOAT, number
from cartgrasp.frames import Array

from .objective import Addition, Cost, Objective, WeightedWrench


@dataclass(frozen=True)
class LeastSideForce(Addition):
    """`weight` per N²."""

    weight: float = 1.0
    base: Objective = field(default_factory=WeightedWrench)

    def __post_init__(self) -> None:
        number("least side force: weight", self.weight, 0.0, MAX_FLOAT)

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        base = self.base.cost(arms, previous)
        return replace(base, side_weight=base.side_weight + self.weight)
