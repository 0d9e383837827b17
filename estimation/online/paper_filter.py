"""The paper's filter as printed, kept so that its failure can be shown. Nobody should use it.

State `(x, y, theta, xd, yd, thetad, phi)` of (8); `qdd = M^-1 P (Gamma - C qd - N)` of (5)-(9), whose projection drops
`Lambdadot qd` (physics.md); world wrench `R(theta) Gamma_b`; Euler steps (16), (17); standard update (18)-(20); all
six velocities and poses measured (10); the wrench taken as exact. `M' = P M` of (7) has no inverse, so M's is used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from cartgrasp.effects import ViscousDrag
from cartgrasp.errors import UsageError
from cartgrasp.first_guess import PHYSICAL_NAMES
from cartgrasp.frames import Array, body_to_world, wrap_angle
from cartgrasp.inertia import N_PHI, physical_from_phi, physical_jacobian
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement, Motion, ParameterEstimate
from cartgrasp.tracked_point import TrackedPoint

from ..noise import FilterNoise
from ..prior import PHYSICAL_UNITS, Prior
from .arguments import check_measurement
from .wrench_sensing import WrenchSensing

DIVERGED = "diverged"
LITERAL = "paper_literal"
MAX_STATE = 1e6


class PaperFilter:
    """The literal form of (8)-(20), with the same interface as `CartFilter`."""

    aligns: ClassVar[bool] = False

    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[str] | None = None,
        *,
        noise: FilterNoise | None = None,
        prior: Prior | None = None,
        yaws: Mapping[str, float] | None = None,
    ) -> None:
        if cart.constraints.n_rows != 1:
            raise UsageError("paper filter: the paper's form knows carts with one rolling constraint only")
        self.cart, self.noise = cart, noise or FilterNoise()
        drags = [effect for effect in cart.effects if isinstance(effect, ViscousDrag)]
        self._sigma = np.array([sum(d.linear for d in drags)] * 2 + [sum(d.angular for d in drags)])
        self._sensing = WrenchSensing(cart, arms, yaws or {}, self.noise.wrench_covariance)
        self._prior, self._tracked = prior or Prior(), TrackedPoint(cart.pose_tb)
        self._mean = np.zeros(6 + N_PHI)
        self._covariance = np.zeros((6 + N_PHI, 6 + N_PHI))
        self._wrench_b = np.zeros(3)
        self._time = np.nan
        self._diverged = False

    def update(self, measurement: Measurement) -> Estimate:
        check_measurement(measurement)
        measurement = self._tracked.at_body(measurement)
        self._sensing.note_contacts(measurement)
        if np.isnan(self._time):
            self._start(measurement)
        elif not self._diverged and measurement.time > self._time:
            self._predict(measurement.time - self._time)
        if measurement.pose is not None and measurement.velocity is not None and not self._diverged:
            self._take(np.concatenate([measurement.pose, measurement.velocity]))
        if measurement.wrenches:
            sensed = self._sensing.sense(measurement, self.cart.parameters)
            if sensed is not None:
                self._wrench_b = self.cart.planar_wrench(sensed.value)
        self._time = max(self._time, measurement.time)
        return self.estimate

    @property
    def estimate(self) -> Estimate:
        phi = self._mean[6:]
        values = physical_from_phi(phi)
        jacobian = physical_jacobian(phi)
        variance = np.diagonal(jacobian @ self._covariance[6:, 6:] @ jacobian.T)
        std = np.sqrt(np.maximum(variance, 0.0))
        prior_std = self._prior.deviations(self.cart)[:N_PHI]
        parameters = {
            name: ParameterEstimate(float(v), float(s), unit, bool(s < 0.5 * p))
            for name, unit, v, s, p in zip(PHYSICAL_NAMES, PHYSICAL_UNITS, values, std, prior_std, strict=True)
        }
        health = DIVERGED if self._diverged else LITERAL
        return Estimate(self._time, self._motion, parameters, health, self.cart, self._model_parameters)

    @property
    def _motion(self) -> Motion:
        velocity_b = body_to_world(self._mean[2]).T @ self._mean[3:6]
        return Motion(self._mean[:3].copy(), self.cart.rolling.free_velocity(velocity_b))

    @property
    def _model_parameters(self) -> Array:
        """Those of the estimate where it is physical, else of the first guess: a controller needs some."""
        mass, _, _, about_com = physical_from_phi(self._mean[6:])
        if self._diverged or not (mass > 0 and about_com > 0 and np.isfinite(self._mean).all()):
            return self.cart.parameters
        return np.concatenate([self._mean[6:], self.cart.parameters[N_PHI:]])

    def _start(self, measurement: Measurement) -> None:
        if measurement.pose is not None:
            self._mean[:3] = measurement.pose
        self._mean[6:] = self.cart.inertia.phi
        self._covariance[:3, :3] = self.noise.pose_covariance
        self._covariance[3:6, 3:6] = np.eye(3)
        self._covariance[6:, 6:] = self._prior.covariance(self.cart)[:N_PHI, :N_PHI]
        self._time = measurement.time

    def _rate(self, state: Array) -> Array:
        """(9), as printed."""
        theta, qd, phi = state[2], state[3:6], state[6:]
        m, mx, my, J = phi
        c, s = np.cos(theta), np.sin(theta)
        across, along = mx * s + my * c, mx * c - my * s
        M = np.array([[m, 0, -across], [0, m, along], [-across, along, J]])
        C = np.zeros((3, 3))
        C[0, 2], C[1, 2] = qd[2] * (my * s - mx * c), -qd[2] * (my * c + mx * s)
        row = np.array([[-s, c, 0.0]])
        inverse = np.linalg.inv(M)
        P = np.eye(3) - row.T @ np.linalg.inv(row @ inverse @ row.T) @ row @ inverse
        push = body_to_world(theta) @ self._wrench_b - C @ qd - self._sigma * qd
        return np.concatenate([qd, inverse @ P @ push, np.zeros(N_PHI)])

    def _predict(self, step: float) -> None:
        try:
            F = self._jacobian()
            density = np.zeros_like(F)
            density[3:6, 3:6] = np.eye(3) * (self.noise.disturbance / self.cart.inertia.mass) ** 2
            drift = self.noise.parameter_drift**2 * self._prior.covariance(self.cart)[:N_PHI, :N_PHI]
            density[6:, 6:] = drift
            self._mean = self._mean + step * self._rate(self._mean)
            self._covariance = self._covariance + step * (F @ self._covariance + self._covariance @ F.T + density)
        except np.linalg.LinAlgError:
            self._diverged = True

    def _jacobian(self) -> Array:
        columns = []
        for i, value in enumerate(self._mean):
            h = np.zeros_like(self._mean)
            h[i] = 1e-6 * max(1.0, abs(value))
            columns.append((self._rate(self._mean + h) - self._rate(self._mean - h)) / (2 * h[i]))
        return np.stack(columns, axis=-1)

    def _take(self, measured: Array) -> None:
        if not np.isfinite(measured).all():
            return
        R = np.zeros((6, 6))
        R[:3, :3], R[3:, 3:] = self.noise.pose_covariance, self.noise.velocity_covariance
        residual = measured - self._mean[:6]
        residual[2] = wrap_angle(residual[2])
        P = self._covariance
        try:
            gain = np.linalg.solve((P[:6, :6] + R).T, P[:, :6].T).T
        except np.linalg.LinAlgError:
            self._diverged = True
            return
        mean, covariance = self._mean + gain @ residual, P - gain @ P[:6]
        if not np.isfinite(mean).all() or np.abs(mean).max() > MAX_STATE or not np.isfinite(covariance).all():
            self._diverged = True
            return
        self._mean, self._covariance = mean, covariance
