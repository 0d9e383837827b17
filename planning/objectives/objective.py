"""What a good allocation is: an Objective answers with a convex quadratic cost of all arms' wrenches F
(6n,)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.frames import Array
from planning.limits import LimitRows


@dataclass(frozen=True, eq=False)
class Cost:
    """`sum weights x² + gradientᵀ x + xᵀ coupling x + constant` over the unknowns x: the wrenches F (6n,), and
    behind them those of the `epigraph`, with their bounds and its rows over all of x. Weights are >= 0, coupling is
    positive semidefinite or None. What doesn't couple arms or axes belongs in the weights: contact choice bounds by
    them. `side_weight` is of the square of the fixed wheels' side force, which `with_side_force` writes out."""

    weights: Array
    gradient: Array
    coupling: Array | None = None
    constant: float = 0.0
    epigraph: LimitRows | None = None
    side_weight: float = 0.0

    def coupled(self, more: Array) -> Cost:
        """The cost with another coupling added."""
        return replace(self, coupling=more if self.coupling is None else self.coupling + more)

    def with_side_force(self, across: Array, straight: float) -> Cost:
        """The cost with `side_weight (straight - across @ F)²` in it; across (6n,), straight in N."""
        if not self.side_weight:
            return self
        across = np.pad(across, (0, len(self.weights) - len(across)))
        return replace(
            self.coupled(self.side_weight * np.outer(across, across)),
            gradient=self.gradient - 2.0 * self.side_weight * straight * across,
            constant=self.constant + self.side_weight * straight**2,
            side_weight=0.0,
        )


class Objective(ABC):
    """Independent of the contacts and of the wrench asked for, so the fast path only changes the equality's
    value."""

    @abstractmethod
    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        """The cost for these arms, `previous` (6n,) being the wrenches of the last plan (zero at first)."""

    @property
    @abstractmethod
    def looks_back(self) -> bool:
        """Whether the cost changes with `previous`."""
