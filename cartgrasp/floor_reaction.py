"""What the floor gives a cart: wheel loads, and the lateral force of its fixed wheels (physics 5).

Both are affine in the sum W (6,) of the hands' spatial wrenches about {b}'s origin, which is on the floor. With w
the planar part of W, e the effects (taken to act at the floor), b the bias and S the free velocities, the cart's
planar momentum changes by

    T = A (w + e - b) + b,   A = M_b S (Sᵀ M_b S)⁻¹ Sᵀ,   and the wheels add   T - w - e = Lambdaᵀ lambda.

For an axle through {b}'s origin, lambda = m (u r + dx r' - dy r²) - fy. With the CoM at height h, the loads N obey

    sum N = m g - Wz,   sum x N = m g dx + W_ty - h T_x,   sum y N = m g dy - W_tx - h T_y,

and are spread as `WheelSet` spreads the weight at rest. How the mass is spread over the height is left out.
`cartgrasp/kernels/floor.py` works it out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from .errors import UsageError
from .frames import Array

if TYPE_CHECKING:
    from .model import CartModel
    from .motion import Motion


@dataclass(frozen=True, eq=False)
class FloorReaction:
    """`loads = load_map @ W + load_offset`, (n_wheels,) N, and `lateral = lateral_map @ W + lateral_offset`, N,
    positive where the floor pushes the cart to its left."""

    load_map: Array
    load_offset: Array
    lateral_map: Array
    lateral_offset: float

    @classmethod
    def of(cls, cart: CartModel, motion: Motion | None = None, time: float = 0.0) -> Self:
        """At a motion; at rest where none is given."""
        if not cart.wheels or cart.com_height is None:
            raise UsageError(f"{cart.name}: wheels and com_height are needed for wheel loads; add them to the cart")
        state = cart.state() if motion is None else cart.state(motion.pose_sb, motion.velocity)
        rows = cart.floor_rows(state, time)
        return cls(rows[:-1, :6], rows[:-1, 6], rows[-1, :6], float(rows[-1, 6]))

    def loads(self, wrench_b: Array) -> Array:
        """N of each wheel, (..., n_wheels), under spatial wrenches (..., 6)."""
        return wrench_b @ self.load_map.T + self.load_offset

    def lateral(self, wrench_b: Array) -> Array:
        """N, (...), under spatial wrenches (..., 6)."""
        return np.asarray(wrench_b @ self.lateral_map + self.lateral_offset)
