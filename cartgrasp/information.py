"""What a stretch of motion teaches: the Fisher information of a cart's parameters, with the noise of the force sensors.

Where the motion is known well, a recorded reduced wrench is `z = required_wrench(theta) + e`, linear in phi, and

    e ~ N(0, R),    R = Sᵀ (sum_i G_i N G_iᵀ) S,    information = sum over samples of Yᵀ R⁻¹ Y

with Y the partials of the required wrench by the parameters, and N the covariance of one arm's recorded wrench. Where
the arms hold enters through R alone: a force's noise comes into the moment by its lever arm. With exact wrenches and
the same motion a contact teaches nothing (physics.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .contacts import grasp_map_planar
from .errors import UsageError
from .frames import Array
from .inertia import N_PHI
from .model import CartModel

KNOWN_INFORMATION = 1e8
"""Information that stands for a known value."""


@dataclass(frozen=True)
class WrenchNoise:
    """White noise of one arm's sensor: standard deviations of a force (N) and a moment component (N·m), and samples
    per second."""

    force: float = 3.0
    moment: float = 0.1
    rate: float = 100.0

    def __post_init__(self) -> None:
        if not (np.isfinite([self.force, self.moment, self.rate]).all() and min(self.force, self.moment) >= 0):
            raise UsageError(f"wrench noise: {self} must be finite, with standard deviations >= 0")
        if self.rate <= 0:
            raise UsageError(f"wrench noise: rate {self.rate} Hz is not positive")

    @property
    def covariance(self) -> Array:
        """Covariance (6, 6) of a spatial wrench in {a}."""
        return np.diag([self.force] * 3 + [self.moment] * 3) ** 2


def reduced_noise(cart: CartModel, points: ArrayLike, noise: WrenchNoise, yaws: ArrayLike = 0.0) -> Array:
    """R, (..., k, k): covariance of the reduced wrench that arms at `points` (..., n, 3) in {b} record together."""
    reduced = cart.basis_b.T @ grasp_map_planar(points, yaws)
    return np.asarray((reduced @ noise.covariance @ np.swapaxes(reduced, -1, -2)).sum(axis=-3))


def parameter_regressor(cart: CartModel, state: Array, acceleration: Array, time: float = 0.0) -> Array:
    """Partials (..., k, p) of `cart.required_wrench` by `cart.parameters`, at states (..., n) and nu' (..., k)."""
    return cart.inverse_by_parameters(state, acceleration, time=time)[1]


def fisher_information(regressor: Array, noise: Array) -> Array:
    """(..., p, p), from the regressors (..., T, k, p) of T samples and their noise covariance (..., k, k)."""
    *_, k, p = regressor.shape
    flat = regressor.reshape(*regressor.shape[:-2], k * p)
    squares = (np.swapaxes(flat, -1, -2) @ flat).reshape(*flat.shape[:-2], k, p, k, p)
    return np.asarray(np.einsum("...ab,...apbq->...pq", np.linalg.inv(noise), squares))


def phi_covariance(information: Array) -> Array:
    """Cramér-Rao bound (..., 4, 4) of phi, all other parameters being unknown too; the information (..., p, p) must
    be regular (a prior makes it so)."""
    return np.asarray(np.linalg.inv(information)[..., :N_PHI, :N_PHI])


def covariance_after(covariance: Array, information: Array) -> Array:
    """(..., p, p) after `information` (..., p, p) came to what was known before: `(1 + P I)⁻¹ P`. What is known for
    sure, or for sure in some combination, needs no inverse and stays so."""
    learned = np.linalg.solve(np.eye(covariance.shape[-1]) + covariance @ information, covariance)
    return np.asarray((learned + np.swapaxes(learned, -1, -2)) / 2)


def information_of(covariance: Array) -> Array:
    """The inverse (p, p) of a covariance (p, p) in which some parameters may be known for sure: they have
    `KNOWN_INFORMATION`."""
    variance = np.diagonal(covariance)
    free = np.flatnonzero(variance > 0)
    information = KNOWN_INFORMATION * np.eye(len(covariance))
    information[np.ix_(free, free)] = np.linalg.inv(covariance[np.ix_(free, free)])
    return information


def phi_scales(phi: Array) -> Array:
    """m (1, l, l, l²) with l = sqrt(J/m), (4,): units in which the directions of phi can be compared."""
    length = np.sqrt(phi[3] / phi[0])
    return np.asarray(phi[0] * np.array([1.0, length, length, length**2]))


def least_known(information: Array, scales: Array) -> tuple[float, Array]:
    """The largest standard deviation over unit directions of `phi / scales`, and that direction (4,)."""
    values, directions = np.linalg.eigh(phi_covariance(information) / np.outer(scales, scales))
    return float(np.sqrt(values[-1])), np.asarray(directions[:, -1])
