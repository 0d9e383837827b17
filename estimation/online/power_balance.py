"""Power balance: powers of wrenches, against those that a cart's inertia and friction take as its first guess has
them."""

from __future__ import annotations

import math
from typing import NamedTuple

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
    def of(cls, products: Array) -> PowerBalance:
        """The sums, of all products (3, 3) of the three."""
        (ii, both, inertial), (_, ff, friction), (_, _, given) = products.tolist()
        return cls(ii, both, ff, inertial, friction, given)

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
