"""Power balance: powers of wrenches, against those that a cart's inertia and friction take as its first guess has
them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array

from .competing_explanations import ROWS_PER_INDEPENDENT_ROW


class PowerBalance(NamedTuple):
    """Sums of products of what inertia (i) and friction (f) of the first guess take, and of these with what wrenches
    give."""

    ii: float
    both: float
    ff: float
    inertial: float
    friction: float
    given: float

    @classmethod
    def of(cls, products: Array, reversed_arm: int | None = None) -> PowerBalance:
        """With the wrench of one arm the other way round; of products (2 + arms, 2 + arms)."""
        signs = np.ones(len(products) - 2)
        if reversed_arm is not None:
            signs[reversed_arm] = -1.0
        (ii, both), (_, ff) = products[:2, :2].tolist()
        inertial, friction = (products[:2, 2:] @ signs).tolist()
        return cls(ii, both, ff, inertial, friction, float(signs @ products[2:, 2:] @ signs))

    def left(self, sign: float, rows: float) -> float:
        """The share of the square of the power that is given which no inertia and no friction that are not negative
        explain, if wrenches are of a sign."""
        if not self.given > 0.0:
            return 1.0
        (moved, _), (rubbed, _) = self.shares(sign, rows)
        if moved > 0 and rubbed > 0:
            explained = sign * (moved * self.inertial + rubbed * self.friction)
        else:
            alone = ((self.inertial, self.ii), (self.friction, self.ff))
            explained = max(max(sign * pull, 0.0) ** 2 / (own + 1e-12) for pull, own in alone)
        return max(self.given - explained, 0.0) / self.given

    def shares(self, sign: float, rows: float) -> tuple[tuple[float, float], ...]:
        """Shares of what the first guess would take for inertia and for friction that are given, each with its standard
        deviation."""
        ii, ff = self.ii * (1.0 + 1e-6) + 1e-12, self.ff * (1.0 + 1e-6) + 1e-12
        size = ii * ff - self.both * self.both
        moved = sign * (ff * self.inertial - self.both * self.friction) / size
        rubbed = sign * (ii * self.friction - self.both * self.inertial) / size
        left = max(self.given - sign * (moved * self.inertial + rubbed * self.friction), 0.0)
        variance = left / max(rows / ROWS_PER_INDEPENDENT_ROW - 2.0, 1.0) / size
        return (moved, math.sqrt(variance * ff)), (rubbed, math.sqrt(variance * ii))
