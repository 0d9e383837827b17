"""What a load change may do to a cart: a point mass is put on or taken off."""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel

from ..prior import Prior

LOAD_STD_RATIO = 0.3
"""Usual size of a load, as a standard deviation, in shares of the mass."""


def load_covariance(cart: CartModel, prior: Prior, mass: float) -> Array:
    """Covariance (p, p) that is added to a cart of a mass (kg): `m (1, x, y, x² + y²)`, with m and (x, y) independent,
    centred on the first guess of the CoM."""
    x, y = cart.inertia.com
    place = prior.com
    shape = np.array([1.0, x, y, x**2 + y**2 + 2 * place**2])
    spread = np.diag([0.0, place**2, place**2, 4 * place**2 * (x**2 + y**2) + 4 * place**4])
    spread[3, 1] = spread[1, 3] = 2 * x * place**2
    spread[3, 2] = spread[2, 3] = 2 * y * place**2
    covariance = np.zeros((len(cart.parameters), len(cart.parameters)))
    covariance[:N_PHI, :N_PHI] = (LOAD_STD_RATIO * mass) ** 2 * (np.outer(shape, shape) + spread)
    return covariance


def root_of(covariance: Array) -> Array:
    """(p, q), with `root @ rootᵀ` the covariance (p, p), and no more columns than it takes."""
    variances, directions = np.linalg.eigh(covariance)
    counts = variances > 1e-15 * variances.max(initial=0.0)
    return np.ascontiguousarray(directions[:, counts] * np.sqrt(variances[counts]))
