"""filterpy's EKF and UKF as one would set them up from a textbook: the state is pose, nu and all parameters, the
recorded wrench is a known input, and its noise is in Q."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np

from cartgrasp.frames import Array, body_to_world, wrap_angle
from cartgrasp.model import CartModel
from cartgrasp.motion import Measurement
from estimation import FilterNoise, Prior
from estimation.gaussian import Gaussian, symmetric
from estimation.online.wrench_sensing import WrenchSensing

BROKEN = np.linalg.LinAlgError, ValueError, OverflowError


class Textbook(ABC):
    """What the two share: a step of the model, and what is seen of it. `diverged` stays once it is true."""

    def __init__(self, cart: CartModel, arms: list[str], noise: FilterNoise, prior: Prior) -> None:
        self.cart, self.diverged = cart, False
        self._noise = noise
        self._sensing = WrenchSensing(cart, arms, {}, noise.wrench_covariance)
        self.n = len(cart.state_names)
        self.size = self.n + len(cart.parameters)
        self.start = np.concatenate([cart.state(), cart.parameters])
        self.spread = np.zeros((self.size, self.size))
        self.spread[: self.n, : self.n] = np.eye(self.n) * np.repeat([1e-3, 0.1], [3, self.n - 3]) ** 2
        self.spread[self.n :, self.n :] = prior.covariance(cart)
        self.R = np.diag(np.concatenate([np.diag(noise.pose_covariance), np.diag(noise.velocity_covariance)]))
        self._wrench_b, self._noise_b, self._time = np.zeros(3), np.zeros((3, 3)), np.nan
        self.online: Any = None

    def update(self, measurement: Measurement) -> None:
        """A pose, a velocity and wrenches of one time."""
        self._sensing.note_contacts(measurement)
        try:
            if not self.diverged:
                self._step(measurement)
        except BROKEN:
            self.diverged = True
        self.diverged |= not np.isfinite(self.online.x).all()

    def _step(self, measurement: Measurement) -> None:
        if np.isfinite(self._time):
            self._predict(measurement.time - self._time)
        self._time = measurement.time
        self._correct(np.concatenate([measurement.pose, measurement.velocity]))
        sensed = self._sensing.sense(measurement, self.cart.parameters)
        if sensed is not None:
            self._wrench_b = self.cart.planar_wrench(sensed.value)
            lift = self.cart.planar_wrench(np.eye(len(sensed.value))).T
            self._noise_b = lift @ sensed.covariance @ lift.T

    @abstractmethod
    def _predict(self, step: float) -> None: ...

    @abstractmethod
    def _correct(self, seen: Array) -> None: ...

    @property
    def phi(self) -> Gaussian:
        """Mean and covariance."""
        at = slice(self.n, self.n + 4)
        return Gaussian(np.asarray(self.online.x).ravel()[at], self.online.P[at, at])

    def _moved(self, x: Array, step: float) -> Array:
        """By the midpoint rule."""
        flow = self.cart.rate(x[: self.n], self._wrench_b, x[self.n :]).value
        half = x[: self.n] + 0.5 * step * flow
        flow = self.cart.rate(half, self._wrench_b, x[self.n :]).value
        return np.concatenate([x[: self.n] + step * flow, x[self.n :]])

    def _partials(self, x: Array, step: float) -> tuple[Array, Array]:
        """Transition, and what the wrench's noise adds in a step."""
        flow = self.cart.rate(x[: self.n], self._wrench_b, x[self.n :])
        rates = np.zeros((self.size, self.size))
        rates[: self.n, : self.n], rates[: self.n, self.n :] = flow.by_state, flow.by_parameters
        F = np.eye(self.size) + step * rates + 0.5 * step**2 * rates @ rates
        Q = np.zeros((self.size, self.size))
        Q[: self.n, : self.n] = step**2 * flow.by_wrench @ self._noise_b @ flow.by_wrench.T
        return F, Q + 1e-14 * np.eye(self.size)

    def _seen(self, x: Array) -> Array:
        velocity = body_to_world(x[2]) @ (self.cart.basis_b @ x[3 : self.n])
        return np.concatenate([x[:3], velocity])

    def _seen_partials(self, x: Array) -> Array:
        H = np.zeros((6, self.size))
        H[:3, :3] = np.eye(3)
        turned = body_to_world(x[2]) @ self.cart.basis_b
        H[3:, 3 : self.n] = turned
        H[3:, 2] = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]) @ turned @ x[3 : self.n]
        return H


def residual(seen: Array, expected: Array) -> Array:
    """With the heading's difference wrapped."""
    off = np.asarray(seen - expected)
    off[2] = wrap_angle(off[2])
    return off


class TextbookEkf(Textbook):
    """filterpy's `ExtendedKalmanFilter`."""

    def __init__(self, cart: CartModel, arms: list[str], noise: FilterNoise, prior: Prior) -> None:
        from filterpy.kalman import ExtendedKalmanFilter

        super().__init__(cart, arms, noise, prior)
        self.online = ExtendedKalmanFilter(dim_x=self.size, dim_z=6)
        self.online.x, self.online.P, self.online.R = self.start, self.spread, self.R

    def _predict(self, step: float) -> None:
        before = self.online.x
        self.online.F, self.online.Q = self._partials(before, step)
        self.online.predict()
        self.online.x = self._moved(before, step)

    def _correct(self, seen: Array) -> None:
        self.online.update(seen, self._seen_partials, self._seen, residual=residual)


class TextbookUkf(Textbook):
    """filterpy's `UnscentedKalmanFilter` with van der Merwe's points."""

    def __init__(self, cart: CartModel, arms: list[str], noise: FilterNoise, prior: Prior) -> None:
        from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

        super().__init__(cart, arms, noise, prior)
        points = MerweScaledSigmaPoints(self.size, alpha=0.1, beta=2.0, kappa=0.0)
        self.online = UnscentedKalmanFilter(
            self.size, 6, 0.01, self._seen, lambda x, dt: self._moved(x, dt), points, residual_z=residual
        )
        self.online.x, self.online.P, self.online.R = self.start, self.spread, self.R

    def _predict(self, step: float) -> None:
        self.online.Q = self._partials(self.online.x, step)[1]
        self.online.P = symmetric(self.online.P)
        self.online.predict(dt=step)

    def _correct(self, seen: Array) -> None:
        self.online.update(seen)
