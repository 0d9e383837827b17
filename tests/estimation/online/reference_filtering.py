"""Predict and update of a Kalman filter, written down again in numpy: what the kernels of the observed wrench are
compared with. `test_filtering.py` compares these with matrix exponentials and the batch solution.

Prediction takes a transition `Phi` and a process noise that is positive semidefinite by construction; the update is
Joseph's form `(I - K H) P (I - K H)ᵀ + K R Kᵀ`, which stays so whatever the rounding (correcting (16), (17), (20)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array
from estimation.gaussian import Gaussian, normalised_square, symmetric


@dataclass(frozen=True)
class Innovation:
    """What a measurement said beyond the prediction: residual (..., m), its covariance, NIS."""

    residual: Array
    covariance: Array

    @property
    def nis(self) -> Array:
        return normalised_square(self.residual, self.covariance)


def transition(jacobian: Array, step: float) -> Array:
    """`exp(F dt)`, (..., n, n), by scaling, a fourth-order Taylor step, and squaring; stiff decays stay decays."""
    scaled = jacobian * step
    halvings = max(0, int(np.ceil(np.log2(np.abs(scaled).sum(axis=-1).max() + 1e-300))) + 2)
    scaled = scaled / 2**halvings
    identity = np.eye(jacobian.shape[-1])
    result = identity + scaled @ (identity + scaled / 2 @ (identity + scaled / 3 @ (identity + scaled / 4)))
    for _ in range(halvings):
        result = result @ result
    return np.asarray(result)


@dataclass(frozen=True)
class Step:
    """A step of the linearised flow: increment of the state, transition, and added noise."""

    increment: Array
    transition: Array
    noise: Array


def exponential_step(rate: Array, jacobian: Array, density: Array, step: float) -> Step:
    """The Rosenbrock-Euler step `∫ exp(F s) ds f`, of second order and stable where F is stiff, with the noise
    `∫ exp(F s) Q exp(F s)ᵀ ds` (Van Loan's integral) by Simpson's rule: a sum of positive semidefinite terms."""
    n = len(rate)
    augmented = np.zeros((n + 1, n + 1))
    augmented[:n, :n], augmented[:n, n] = jacobian, rate
    half = transition(augmented, step / 2)
    whole = half @ half
    middle, end = half[:n, :n], whole[:n, :n]
    noise = step / 6 * (density + 4 * _congruence(middle, density) + _congruence(end, density))
    return Step(whole[:n, n], end, noise)


def predicted(prior: Gaussian, step: Step) -> Gaussian:
    """The Gaussian after a step."""
    covariance = _congruence(step.transition, prior.covariance) + step.noise
    return Gaussian(prior.mean + step.increment, symmetric(covariance))


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
