"""How much of what pushes beside all that is known the arms answer by as much the other way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.checks import MAX_NUMBER, number
from cartgrasp.frames import Array
from cartgrasp.motion import Disturbance


@dataclass(frozen=True)
class Rejection:
    """Fed forward at most; what is beyond is left to feedback: somebody who holds the cart is stronger than that.

    Args:
        force: N, of each direction that is free.
        moment: N·m.

    Raises:
        UsageError: A number is negative or not finite.
    """

    force: float = 80.0
    moment: float = 25.0

    def __post_init__(self) -> None:
        for name in ("force", "moment"):
            number(f"rejection: {name}", getattr(self, name), 0.0, MAX_NUMBER)

    def fed_forward(self, disturbance: Disturbance) -> Array:
        """The reduced wrench (k,) of the arms against it."""
        k = len(disturbance.wrench)
        most = np.array([self.force] if k == 1 else [*[self.force] * (k - 1), self.moment])
        return -np.clip(disturbance.wrench, -most, most)
