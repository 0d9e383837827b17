"""What the floor gives a cart: wheel loads, and the lateral force of its fixed wheels (physics 5).

Both are affine in the sum W (6,) of the hands' spatial wrenches about {b}'s origin, which is on the floor. With w
the planar part of W, e the effects (taken to act at the floor), b the bias and S the free velocities, the cart's
planar momentum changes by

    T = A (w + e - b) + b,   A = M_b S (Sᵀ M_b S)⁻¹ Sᵀ,   and the wheels add   T - w - e = Lambdaᵀ lambda.

For an axle through {b}'s origin, lambda = m (u r + dx r' - dy r²) - fy. With the CoM at height h, the loads N obey

    sum N = m g - Wz,   sum x N = m g dx + W_ty - h T_x,   sum y N = m g dy - W_tx - h T_y,

and are spread as `WheelSet` spreads the weight at rest. How the mass is spread over the height is left out.

Along a direction of the cart's parameters, with dM, db and de the slopes of M_b, b and e,

    dA = (1 - A) dM G,   G = S (Sᵀ M_b S)⁻¹ Sᵀ,   dT = dA (w + e - b) + A de + (1 - A) db,

and with it the loads and lambda have slopes; M_b and b are linear in phi.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Self

import numpy as np

from .contacts import PLANAR_ROWS
from .errors import UsageError
from .frames import Array
from .rigid_body import bias_b, mass_matrix_b
from .wheels import GRAVITY

if TYPE_CHECKING:
    from .model import Acting, CartModel
    from .motion import Motion


@dataclass(frozen=True, eq=False)
class FloorReaction:
    """`loads = load_map @ W + load_offset`, (n_wheels,) N, and `lateral = lateral_map @ W + lateral_offset`, N,
    positive where the floor pushes the wheels to their left."""

    load_map: Array
    load_offset: Array
    lateral_map: Array
    lateral_offset: Array

    @classmethod
    def of(cls, cart: CartModel, motion: Motion | None = None, time: float = 0.0) -> Self:
        """At a motion; at rest where none is given."""
        acting, velocity_b = _acting(cart, motion, time)
        bias = bias_b(velocity_b, acting.phi)[0]
        inertial = mass_matrix_b(acting.phi) @ _mobility(cart, acting.phi)
        rate = _Affine(inertial, inertial @ (acting.wrench_b - bias) + bias)
        return cls._by(cart, rate, _Affine(np.eye(3), acting.wrench_b), acting.phi)

    @classmethod
    def by_parameters(cls, cart: CartModel, motion: Motion | None = None, time: float = 0.0) -> Self:
        """The partials of all four by the cart's parameters (p,), on a leading axis."""
        acting, velocity_b = _acting(cart, motion, time)
        by_phi, effects = acting.phi_by_parameters.T, acting.wrench_by_parameters.T
        mobility = _mobility(cart, acting.phi)
        inertial, turned = mass_matrix_b(acting.phi) @ mobility, mass_matrix_b(by_phi) @ mobility
        push, bias = acting.wrench_b - bias_b(velocity_b, acting.phi)[0], bias_b(velocity_b, by_phi)[0]
        kept = np.eye(3) - inertial
        rate = _Affine(kept @ turned, (turned @ push + bias) @ kept.T + effects @ inertial.T)
        return cls._by(cart, rate, _Affine(np.zeros((3, 3)), effects), by_phi)

    def along(self, direction: Array) -> Self:
        """Partials by the parameters, summed along a direction (p,) of these."""
        p, n_wheels, columns = self.load_map.shape
        load_map = (direction @ self.load_map.reshape(p, -1)).reshape(n_wheels, columns)
        rest = (direction @ field for field in (self.load_offset, self.lateral_map, self.lateral_offset))
        return type(self)(load_map, *rest)

    @classmethod
    def _by(cls, cart: CartModel, rate: _Affine, given: _Affine, phi: Array) -> Self:
        """From T, from what is given beside the floor's push, w + e, and from phi; or from partials of the three."""
        planar, hands, height = np.eye(6)[list(PLANAR_ROWS)], given.by_planar[0, 0], _height(cart)
        balance = np.zeros((*phi.shape[:-1], 3, 6))
        balance[..., 0, 2], balance[..., 1, 4], balance[..., 2, 3] = -hands, hands, -hands
        balance[..., 1:, :] -= height * rate.by_planar[..., :2, :] @ planar
        weight = GRAVITY * phi[..., :3]
        weight[..., 1:] -= height * rate.offset[..., :2]
        spread = cart.wheel_set.load_map[:, :3] / GRAVITY
        across = cart.rolling.across_b
        lateral = across @ (rate.by_planar - given.by_planar)[..., :2, :]
        offset = (rate.offset - given.offset)[..., :2] @ across
        return cls(spread @ balance, weight @ spread.T, lateral @ planar, offset)

    def loads(self, wrench_b: Array) -> Array:
        """N of each wheel, (..., n_wheels), under spatial wrenches (..., 6)."""
        return wrench_b @ self.load_map.T + self.load_offset

    def lateral(self, wrench_b: Array) -> Array:
        """N, (...), under spatial wrenches (..., 6)."""
        return np.asarray(wrench_b @ self.lateral_map + self.lateral_offset)


class _Affine(NamedTuple):
    """`by_planar @ w + offset`, (3,)."""

    by_planar: Array
    offset: Array


def _acting(cart: CartModel, motion: Motion | None, time: float) -> tuple[Acting, Array]:
    """What acts on the cart, and its velocity (u, w, r)."""
    state = cart.state() if motion is None else cart.state(motion.pose_sb, motion.velocity)
    return cart.acting(state, time=time), cart.basis_b @ state[cart.velocity_slice]


def _height(cart: CartModel) -> float:
    if not cart.wheels or cart.com_height is None:
        raise UsageError(f"{cart.name}: wheels and com_height are needed for wheel loads; add them to the cart")
    return cart.com_height


def _mobility(cart: CartModel, phi: Array) -> Array:
    """S (Sᵀ M_b S)⁻¹ Sᵀ."""
    basis = cart.basis_b
    return np.asarray(basis @ np.linalg.inv(basis.T @ mass_matrix_b(phi) @ basis) @ basis.T)
