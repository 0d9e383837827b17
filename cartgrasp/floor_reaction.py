"""What the floor gives a cart: wheel loads, and the lateral force of its fixed wheels (physics.md).

Both are affine in the sum W (6,) of the hands' spatial wrenches about {b}'s origin, which is on the floor. With w
the planar part of W, e the effects, b the bias and S the free velocities, the cart's planar momentum changes by

    T = A (w + e - b) + b,   A = M_b S (Sᵀ M_b S)⁻¹ Sᵀ,   and the wheels add   T - w - e = Lambdaᵀ lambda.

For an axle through {b}'s origin, lambda = m (u r + dx r' - dy r²) - fy. With the CoM at height h, the loads N obey

    sum N = m g - Wz,   sum x N = m g dx + W_ty + h (p_x - T_x),   sum y N = m g dy - W_tx + h (p_y - T_y),

with p the pull of a floor's slope, which is at the CoM. All other effects are taken to act at the floor. The loads are
spread as `WheelSet` spreads the weight at rest. How the mass is spread over the height is left out.
`cartgrasp/kernels/floor.py` works it out.

Along a direction of the cart's parameters, with dM, db and de the slopes of M_b, b and e,

    dA = (1 - A) dM G,   G = S (Sᵀ M_b S)⁻¹ Sᵀ,   dT = dA (w + e - b) + A de + (1 - A) db,

and with it the loads and lambda have slopes; M_b and b are linear in phi.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Self

import numpy as np

from .errors import UsageError
from .frames import PLANAR, Array
from .model import CartModel
from .motion import Motion

TO_PLANAR = np.eye(6)[[*PLANAR]]


@dataclass(frozen=True, eq=False)
class FloorReaction:
    """`rows @ (W, 1)`, N: `rows` (n_wheels + 1, 7) are of each wheel's load and, last, of the lateral force, which is
    positive where the floor pushes the fixed wheels to their left."""

    rows: Array

    @classmethod
    def of(cls, cart: CartModel, motion: Motion | None = None, time: float = 0.0) -> Self:
        """At a motion; at rest where none is given. Without wheels or `com_height` it tells no loads."""
        return cls(_told(cart, cart.floor_rows(_state(cart, motion), time)[0]))

    @classmethod
    def with_partials(cls, cart: CartModel, motion: Motion | None = None, time: float = 0.0) -> tuple[Self, Array]:
        """And the partials of its rows by the cart's parameters, (p, n_wheels + 1, 7)."""
        rows = _told(cart, cart.floor_rows(_state(cart, motion), time, with_partials=True))
        return cls(rows[0]), rows[1:]

    @property
    def load_map(self) -> Array:
        """(..., n_wheels, 6)."""
        return self.rows[..., :-1, :6]

    @property
    def load_offset(self) -> Array:
        """(..., n_wheels), N."""
        return self.rows[..., :-1, 6]

    @property
    def lateral_map(self) -> Array:
        """(..., 6)."""
        return self.rows[..., -1, :6]

    @property
    def lateral_offset(self) -> Array:
        """(...), N."""
        return self.rows[..., -1, 6]

    def loads(self, wrench_b: Array) -> Array:
        """N of each wheel, (..., n_wheels), under spatial wrenches (..., 6)."""
        return wrench_b @ self.load_map.T + self.load_offset

    def lateral(self, wrench_b: Array) -> Array:
        """N, (...), under spatial wrenches (..., 6)."""
        return np.asarray(wrench_b @ self.lateral_map + self.lateral_offset)


class WheelForces(NamedTuple):
    """What the wheels take, N: all fixed ones together sideways, positive where the floor pushes them to their left (0
    where all are casters), and each wheel's load (n_wheels,), None where the cart tells no wheels or no `com_height`.
    Below zero a wheel has left the floor, and the others carry more than is told."""

    side: float
    loads: Array | None

    @classmethod
    def of(cls, cart: CartModel, wrench_b: Array, motion: Motion | None = None, time: float = 0.0) -> Self:
        """Under a spatial wrench (6,) of the hands about {b}'s origin, at a motion or at rest."""
        rows = cart.floor_rows(_state(cart, motion), time)[0]
        forces = rows[:, :6] @ wrench_b + rows[:, 6]
        return cls(float(forces[-1]), forces[:-1] if tells_loads(cart) else None)


def straight_force(cart: CartModel, motion: Motion | None = None, time: float = 0.0) -> tuple[Array, float]:
    """What the fixed wheels take sideways, N, of hands that give the effective rows of a planar wrench (3,), and
    nothing across the wheels: its slope (3,) by the wrench, and what there is without any."""
    row, slope = cart.floor_rows(_state(cart, motion), time)[0, -1], np.zeros(3)
    slope[:2] = cart.rolling.across_b
    return slope + TO_PLANAR @ row[:6], float(row[6])


def tells_loads(cart: CartModel) -> bool:
    return bool(cart.wheels) and cart.com_height is not None


def n_loads(cart: CartModel) -> int:
    """How many wheels' loads are told."""
    return len(cart.wheels) if tells_loads(cart) else 0


def check_loads(cart: CartModel) -> None:
    if not tells_loads(cart):
        raise UsageError(f"{cart.name}: wheels and com_height are needed for wheel loads; add them to the cart")


def _told(cart: CartModel, rows: Array) -> Array:
    """The rows that the cart tells, of rows (..., n_wheels + 1, 7)."""
    return rows if tells_loads(cart) else rows[..., -1:, :]


def _state(cart: CartModel, motion: Motion | None) -> Array:
    return cart.state() if motion is None else cart.state(motion.pose_sb, motion.velocity)
