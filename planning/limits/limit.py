"""What an arm's wrench in {a} must obey: a Limit answers with bounds, linear rows and cones, each with a
name."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from cartgrasp.arms import Arm
from cartgrasp.contacts import WRENCH_NAMES
from cartgrasp.frames import Array
from planning.quadratic_program import Cone


@dataclass(frozen=True, eq=False)
class LimitRows:
    """`lower <= F <= upper` (6,), `low_limits <= rows @ F <= limits` (k, 6), and cones on F (6,); of several arms
    side by side F is (6n,). Low limits that are left out are infinite, and called as the limits are."""

    lower: Array = field(default_factory=lambda: np.full(6, -np.inf))
    upper: Array = field(default_factory=lambda: np.full(6, np.inf))
    lower_names: tuple[str, ...] = tuple(f"{name} lower" for name in WRENCH_NAMES)
    upper_names: tuple[str, ...] = tuple(f"{name} upper" for name in WRENCH_NAMES)
    rows: Array = field(default_factory=lambda: np.zeros((0, 6)))
    limits: Array = field(default_factory=lambda: np.zeros(0))
    names: tuple[str, ...] = ()
    cones: tuple[Cone, ...] = ()
    low_limits: Array = field(default_factory=lambda: np.zeros(0))
    low_names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if len(self.low_limits) != len(self.limits):
            object.__setattr__(self, "low_limits", np.full(len(self.limits), -np.inf))
            object.__setattr__(self, "low_names", self.names)

    def followed_by(self, other: LimitRows) -> LimitRows:
        """These, and bounds of further unknowns; both have rows over all unknowns."""
        return LimitRows(
            np.concatenate([self.lower, other.lower]),
            np.concatenate([self.upper, other.upper]),
            self.lower_names + other.lower_names,
            self.upper_names + other.upper_names,
            np.vstack([self.rows, other.rows]),
            np.concatenate([self.limits, other.limits]),
            self.names + other.names,
            self.cones + other.cones,
            np.concatenate([self.low_limits, other.low_limits]),
            self.low_names + other.low_names,
        )

    def __and__(self, other: LimitRows) -> LimitRows:
        """Both limits at once: of two bounds the tighter one stays, with its name."""
        lower_ours, upper_ours = self.lower >= other.lower, self.upper <= other.upper
        return LimitRows(
            np.maximum(self.lower, other.lower),
            np.minimum(self.upper, other.upper),
            _pick(lower_ours, self.lower_names, other.lower_names),
            _pick(upper_ours, self.upper_names, other.upper_names),
            np.vstack([self.rows, other.rows]),
            np.concatenate([self.limits, other.limits]),
            self.names + other.names,
            self.cones + other.cones,
            np.concatenate([self.low_limits, other.low_limits]),
            self.low_names + other.low_names,
        )


class Limit(ABC):
    """A convex set of wrenches that holds the zero wrench, so a wrench scaled down stays inside."""

    @abstractmethod
    def rows(self, arm: Arm) -> LimitRows:
        """The limit of this arm; names without the arm's."""


def _pick(ours: NDArray[np.bool_], names: tuple[str, ...], others: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(a if mine else b for mine, a, b in zip(ours, names, others, strict=True))
