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
    """`lower <= F <= upper` (6,), `rows @ F <= limits` (k, 6), and cones on F (6,)."""

    lower: Array = field(default_factory=lambda: np.full(6, -np.inf))
    upper: Array = field(default_factory=lambda: np.full(6, np.inf))
    lower_names: tuple[str, ...] = tuple(f"{name} lower" for name in WRENCH_NAMES)
    upper_names: tuple[str, ...] = tuple(f"{name} upper" for name in WRENCH_NAMES)
    rows: Array = field(default_factory=lambda: np.zeros((0, 6)))
    limits: Array = field(default_factory=lambda: np.zeros(0))
    names: tuple[str, ...] = ()
    cones: tuple[Cone, ...] = ()

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
        )


class Limit(ABC):
    """A convex set of wrenches that holds the zero wrench, so a wrench scaled down stays inside."""

    @abstractmethod
    def rows(self, arm: Arm) -> LimitRows:
        """The limit of this arm; names without the arm's."""


def _pick(ours: NDArray[np.bool_], names: tuple[str, ...], others: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(a if mine else b for mine, a, b in zip(ours, names, others, strict=True))
