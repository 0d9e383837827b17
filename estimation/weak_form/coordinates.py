"""Coordinates in which every cart is physical: the logarithms of mass and inertia about the CoM, the CoM, and the
effects' parameters. A first guess of mass and inertia is known up to a factor, so its prior is log-normal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI, phi_from_physical, physical_from_phi, physical_jacobian
from cartgrasp.model import CartModel


@dataclass(frozen=True)
class ParameterPrior:
    """Prior of the logarithms of mass and inertia, the CoM (m) and the effects' parameters, each with its mean and
    standard deviation (p,). Those that are `free` (p,) are estimated."""

    mean: Array
    std: Array
    free: np.ndarray


def coordinates(cart: CartModel) -> Array:
    values = cart.parameters.copy()
    mass, x, y, inertia = physical_from_phi(values[:N_PHI])
    values[:N_PHI] = np.log(mass), x, y, np.log(inertia)
    return values


def with_coordinates(cart: CartModel, z: Array) -> CartModel:
    values = parameters_at(z)
    if np.array_equal(z[:N_PHI], coordinates(cart)[:N_PHI]):  # a body that is given stays as it is, to the bit
        values[:N_PHI] = cart.parameters[:N_PHI]
    return cart.with_parameters(values)


def parameters_at(z: Array) -> Array:
    """Parameters (p,) at coordinates (p,)."""
    return np.append(phi_from_physical(np.exp(z[0]), z[1], z[2], np.exp(z[3])), z[N_PHI:])


def slopes_at(z: Array) -> Array:
    """Jacobian (p, p) of the parameters with respect to coordinates (p,)."""
    found = np.eye(len(z))
    by_physical = np.linalg.inv(physical_jacobian(parameters_at(z)[:N_PHI]))
    found[:N_PHI, :N_PHI] = by_physical * [np.exp(z[0]), 1.0, 1.0, np.exp(z[3])]
    return found


def jacobian(cart: CartModel) -> Array:
    """Jacobian (p, p) of the parameters with respect to the coordinates."""
    return slopes_at(coordinates(cart))


def bounds(cart: CartModel) -> tuple[Array, Array]:
    """Least and largest coordinates (p,)."""
    effects = [parameter for effect in cart.effects for parameter in effect.parameters]
    none = np.full(N_PHI, np.inf)
    return np.append(-none, [p.lower for p in effects]), np.append(none, [p.upper for p in effects])
