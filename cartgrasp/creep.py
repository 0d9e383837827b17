"""The sideways creep of fixed wheels (`effects/lateral_slip.py`), and what it adds to the rate of the pose.

The wheels take what is left of the balance of forces (`floor_reaction.py`), with S the free velocities and n across
the wheels:

    lambda = n · (M_b S nu' + bias - wrench_b - effects).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .compiled_dynamics import StatePoint
from .frames import Array
from .model import CartModel
from .rigid_body import bias_b, mass_matrix_b, regressor_b

Rates = tuple[Array, ...]
"""Rate of the state (..., n) and its partials by state (..., n, n), wrench (..., n, 3) and parameters (..., n, p)."""


@dataclass(frozen=True)
class SideForce:
    """lambda (...), N, of the floor on the wheels, to their left; its partials by state, wrench and parameters."""

    value: Array
    by_state: Array
    by_wrench: Array
    by_parameters: Array

    @classmethod
    def of(cls, cart: CartModel, point: StatePoint, wrench_b: Array, rates: Rates) -> SideForce:
        state, nu = point[0], cart.velocity_slice
        phi, phi_by_parameters, effects, _, swung = cart.effect_parts(point)
        across, basis = np.append(cart.rolling.across_b, 0.0), cart.basis_b
        velocity_b = state[..., nu] @ basis.T
        acceleration_b = rates[0][..., nu] @ basis.T
        regressor, ahead = regressor_b(velocity_b, acceleration_b), across[0] * acceleration_b[..., :1]
        momentum_rate = (regressor @ phi[..., None])[..., 0]
        by_acceleration = across @ mass_matrix_b(phi) @ basis - swung.value * across[0] * basis[0]
        by_state, by_wrench, by_parameters = (_row(by_acceleration, part[..., nu, :]) for part in rates[1:])
        by_state[..., :3] -= across @ effects.by_pose
        by_state[..., nu] += across @ (bias_b(velocity_b, phi)[1] - effects.by_velocity) @ basis
        by_state[..., cart.memory_slice] -= across @ effects.by_memory
        by_parameters += across @ ((regressor - effects.by_phi) @ phi_by_parameters - effects.by_parameters)
        by_parameters -= ahead * swung.by_parameters[..., 0, :]
        value = (momentum_rate - wrench_b - effects.value) @ across - (ahead * swung.value)[..., 0]
        return cls(value, by_state, by_wrench - across, by_parameters)


def creeping(cart: CartModel, point: StatePoint, wrench_b: Array, rates: Rates) -> Rates:
    """The rates with the wheels' creep in those of the pose."""
    state, first = point[0], cart.velocity_slice.start
    force = SideForce.of(cart, point, wrench_b, rates)
    speed = state[..., first]
    share = -cart.slip_compliance * np.abs(speed)
    creep = share * force.value
    by_state, by_wrench, by_parameters = (
        share[..., None] * partials for partials in (force.by_state, force.by_wrench, force.by_parameters)
    )
    by_state[..., first] -= cart.slip_compliance * np.sign(speed) * force.value
    heading = state[..., 2] + cart.rolling.angle
    across = np.stack([-np.sin(heading), np.cos(heading)], axis=-1)
    turned = np.stack([-np.cos(heading), -np.sin(heading)], axis=-1)
    value, *partials = (part.copy() for part in rates)
    value[..., :2] += creep[..., None] * across
    for whole, part in zip(partials, (by_state, by_wrench, by_parameters), strict=True):
        whole[..., :2, :] += across[..., None] * part[..., None, :]
    partials[0][..., :2, 2] += creep[..., None] * turned
    return value, partials[0], partials[1], partials[2]


def _row(row: Array, matrix: Array) -> Array:
    """A row (..., f) times a matrix (..., f, k)."""
    return np.asarray((row[..., None, :] @ matrix)[..., 0, :])
