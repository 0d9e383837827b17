"""What a good allocation is: an Objective answers with a convex quadratic cost of all arms' wrenches F (6n,), by
default with that of the contract, the effort."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.frames import Array
from planning.limits import LimitRows

ABOVE_ZERO = {"least": "above 0"}
"""Metadata of a field whose value has to be: problem files ask it."""


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

    @property
    def hessian(self) -> Array:
        """The second derivative over x, without that of the side force."""
        hessian = np.diag(2.0 * self.weights)
        return hessian if self.coupling is None else hessian + 2.0 * self.coupling

    def coupled(self, more: Array) -> Cost:
        """The cost with another coupling added, over x or over F alone."""
        more = np.pad(more, (0, len(self.weights) - len(more)))
        return replace(self, coupling=more if self.coupling is None else self.coupling + more)

    def with_side_force(self, across: Array, straight: float) -> Cost:
        """The cost with `side_weight (straight - across @ F)²` in it; across (6n,), straight in N."""
        gradient = self.gradient.copy()
        gradient[: len(across)] -= 2.0 * self.side_weight * straight * across
        return replace(
            self.coupled(self.side_weight * np.outer(across, across)),
            gradient=gradient,
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


class Addition(Objective):
    """What adds to the cost of a `base`: a dataclass, whose name and numbers are keys of problem files. Of several, one
    that `adds_unknowns` comes last."""

    base: Objective
    adds_unknowns: ClassVar[bool] = False

    @property
    def looks_back(self) -> bool:
        return self.base.looks_back


class WeightedWrench(Objective):
    """The effort: the sum of each arm's `weights` times component squared, over arms and axes (N², without a ½)."""

    @property
    def looks_back(self) -> bool:
        return False

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        weights = np.concatenate([arm.weights for arm in arms])
        return Cost(weights, np.zeros(len(weights)))


class Nothing(Objective):
    """Costs nothing: a base for an objective that is to stand alone, as `Lexicographic` may want it."""

    @property
    def looks_back(self) -> bool:
        return False

    def cost(self, arms: Sequence[Arm], previous: Array) -> Cost:
        return Cost(np.zeros(6 * len(arms)), np.zeros(6 * len(arms)))
