"""Coordinates in which every cart is physical: the logarithms of mass and inertia about the CoM, the CoM, and the
effects' parameters. A first guess of mass and inertia is known up to a factor, so its prior is log-normal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI, physical_from_phi
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
    mass, x, y, inertia = np.exp(z[0]), z[1], z[2], np.exp(z[3])
    return np.concatenate([mass * np.array([1.0, x, y, x**2 + y**2]) + [0.0, 0.0, 0.0, inertia], z[N_PHI:]])


def slopes_at(z: Array) -> Array:
    """Jacobian (p, p) of the parameters with respect to coordinates (p,)."""
    mass, x, y, inertia = np.exp(z[0]), z[1], z[2], np.exp(z[3])
    found = np.eye(len(z))
    found[:N_PHI, 0] = mass * np.array([1.0, x, y, x**2 + y**2])
    found[1, 1], found[3, 1] = mass, 2.0 * mass * x
    found[2, 2], found[3, 2] = mass, 2.0 * mass * y
    found[3, 3] = inertia
    return found


def jacobian(cart: CartModel) -> Array:
    """Jacobian (p, p) of the parameters with respect to the coordinates."""
    return slopes_at(coordinates(cart))


def bounds(cart: CartModel) -> tuple[Array, Array]:
    """Least and largest coordinates (p,)."""
    effects = [parameter for effect in cart.effects for parameter in effect.parameters]
    none = np.full(N_PHI, np.inf)
    return np.append(-none, [p.lower for p in effects]), np.append(none, [p.upper for p in effects])
