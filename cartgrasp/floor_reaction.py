"""What the floor gives a cart: wheel loads, and the lateral force of its fixed wheels (physics 5).

Both are affine in the sum W (6,) of the hands' spatial wrenches about {b}'s origin, which is on the floor. With w
the planar part of W, e the effects (taken to act at the floor), b the bias and S the free velocities, the cart's
planar momentum changes by

    T = A (w + e - b) + b,   A = M_b S (Sᵀ M_b S)⁻¹ Sᵀ,   and the wheels add   T - w - e = Lambdaᵀ lambda.

For an axle through {b}'s origin, lambda = m (u r + dx r' - dy r²) - fy. With the CoM at height h, the loads N obey

    sum N = m g - Wz,   sum x N = m g dx + W_ty - h T_x,   sum y N = m g dy - W_tx - h T_y,

and are spread as `WheelSet` spreads the weight at rest. How the mass is spread over the height is left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np

from .contacts import PLANAR_ROWS
from .errors import UsageError
from .frames import Array
from .rigid_body import bias_b, mass_matrix_b
from .wheels import GRAVITY

if TYPE_CHECKING:
    from .model import CartModel
    from .motion import Motion


@dataclass(frozen=True, eq=False)
class FloorReaction:
    """`loads = load_map @ W + load_offset`, (n_wheels,) N, and `lateral = lateral_map @ W + lateral_offset`, N,
    positive where the floor pushes the wheels to their left."""

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
        phi, basis = cart.phi_at(time), cart.basis_b
        mass_matrix = mass_matrix_b(phi)
        bias = bias_b(basis @ state[cart.velocity_slice], phi)[0]
        push = cart.effect_wrench(state, time=time) - bias
        inertial = mass_matrix @ basis @ np.linalg.inv(basis.T @ mass_matrix @ basis) @ basis.T
        planar = np.eye(6)[list(PLANAR_ROWS)]
        balance = np.zeros((3, 6))
        balance[0, 2], balance[1, 4], balance[2, 3] = -1.0, 1.0, -1.0
        balance[1:] -= cart.com_height * inertial[:2] @ planar
        weight = GRAVITY * phi[:3]
        weight[1:] -= cart.com_height * (inertial @ push + bias)[:2]
        spread = cart.wheel_set.load_map[:, :3] / GRAVITY
        across = cart.rolling.across_b @ (inertial - np.eye(3))[:2]
        return cls(spread @ balance, spread @ weight, across @ planar, float(across @ push))

    def loads(self, wrench_b: Array) -> Array:
        """N of each wheel, (..., n_wheels), under spatial wrenches (..., 6)."""
        return wrench_b @ self.load_map.T + self.load_offset

    def lateral(self, wrench_b: Array) -> Array:
        """N, (...), under spatial wrenches (..., 6)."""
        return np.asarray(wrench_b @ self.lateral_map + self.lateral_offset)
