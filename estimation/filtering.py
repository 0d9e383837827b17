"""Predict and update of a Kalman filter: pure functions that broadcast over leading axes.

Prediction takes a transition `Phi` and a process noise that is positive semidefinite by construction; the update is
Joseph's form `(I - K H) P (I - K H)ᵀ + K R Kᵀ`, which stays so whatever the rounding (correcting (16), (17), (20)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array

from .gaussian import Gaussian, normalised_square, symmetric


@dataclass(frozen=True)
class Innovation:
    """What a measurement said beyond the prediction: residual (..., m), its covariance, NIS."""

    residual: Array
    covariance: Array

    @property
    def nis(self) -> Array:
        return normalised_square(self.residual, self.covariance)


def transition(jacobian: Array, step: float) -> Array:
    """`exp(F dt)` to fourth order, (..., n, n); F dt is small at every step this library takes."""
    scaled = jacobian * step
    identity = np.eye(jacobian.shape[-1])
    return identity + scaled @ (identity + scaled / 2 @ (identity + scaled / 3 @ (identity + scaled / 4)))


def discretised(jacobian: Array, density: Array, step: float) -> tuple[Array, Array]:
    """Transition, and `∫ exp(F s) Q exp(F s)ᵀ ds` (Van Loan's integral) by Simpson's rule: of fourth order, and a sum
    of positive semidefinite terms."""
    half = transition(jacobian, step / 2)
    whole = half @ half
    noise = density + 4 * _congruence(half, density) + _congruence(whole, density)
    return whole, step / 6 * noise


def predicted(prior: Gaussian, mean: Array, phi: Array, noise: Array) -> Gaussian:
    """The Gaussian after a step to `mean`, with transition `phi` and added `noise`."""
    return Gaussian(mean, symmetric(_congruence(phi, prior.covariance) + noise))


def innovation(prior: Gaussian, residual: Array, H: Array, R: Array) -> Innovation:
    return Innovation(residual, symmetric(_congruence(H, prior.covariance) + R))


def updated(prior: Gaussian, news: Innovation, H: Array, R: Array) -> Gaussian:
    """(18)-(19) and Joseph's form."""
    gain = np.swapaxes(np.linalg.solve(news.covariance, H @ prior.covariance), -1, -2)
    mean = prior.mean + (gain @ news.residual[..., None])[..., 0]
    keep = np.eye(prior.mean.shape[-1]) - gain @ H
    return Gaussian(mean, symmetric(_congruence(keep, prior.covariance) + _congruence(gain, R)))


def _congruence(matrix: Array, covariance: Array) -> Array:
    return np.asarray(matrix @ covariance @ np.swapaxes(matrix, -1, -2))
