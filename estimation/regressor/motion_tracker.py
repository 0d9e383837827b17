"""Pose, nu and nu' while they happen, from poses and velocities alone: a Kalman filter with white jerk, and its
smoothing over the last moments (Rauch, Tung and Striebel 1965).

Wrenches stay out: what they are regressed on has then no share in their noise (errors in variables, physics 11). They
say only when there may be a jolt, which white jerk would smooth away.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array, body_to_world, rotation_planar, wrap_angle
from cartgrasp.model import CartModel

from ..filtering import innovation, updated
from ..gaussian import Gaussian, symmetric
from ..noise import FilterNoise

JERK = 3.0
"""m/s³ √s or rad/s³ √s: root density; high enough that hands which wander smoothly are not smoothed away."""
UNKNOWN = (10.0, 1.0, 3.0)
"""Standard deviations of pose, nu and nu' before anything is measured."""
PATH_FLOOR = 1e-6
"""m, rad: what a step's quadrature may miss."""
MEASUREMENT_FLOOR = 1e-10
GATE = 25.0
"""Normalised squares, by component, beyond which a sample pulls less."""


@dataclass(frozen=True)
class Moment:
    """`(pose, nu, nu')` at a time: as predicted by `transition` from the moment before, and with what was measured."""

    time: float
    transition: Array
    predicted: Gaussian
    believed: Gaussian


@dataclass(frozen=True)
class Stretch:
    """Smoothed moments: time (n,), pose (n, 3), nu (n, f), nu' (n, f), and the covariance of nu (n, f, f)."""

    time: Array
    pose: Array
    velocity: Array
    acceleration: Array
    velocity_covariance: Array

    def until(self, k: int) -> Stretch:
        """The moments up to and with the k-th."""
        end = k + 1
        return Stretch(
            *(part[:end] for part in (self.time, self.pose, self.velocity, self.acceleration, self.velocity_covariance))
        )


class MotionTracker:
    """Steps from moment to moment."""

    def __init__(self, cart: CartModel, noise: FilterNoise) -> None:
        self.cart, self.noise = cart, noise
        self._basis, self._project = cart.basis_b, np.linalg.pinv(cart.basis_b)
        self._free = cart.constraints.n_free
        self._nu = slice(3, 3 + self._free)
        self._sideways = noise.sideways(cart)

    def first(self, time: float, pose: Array) -> Moment:
        """Of a pose that may be NaN in parts."""
        known = np.isfinite(pose)
        mean = np.zeros(3 + 2 * self._free)
        mean[:3] = np.where(known, pose, 0.0)
        std = np.repeat(UNKNOWN, [3, self._free, self._free])
        std[:3] = np.where(known, np.sqrt(np.diag(self.noise.pose_covariance)), std[:3])
        start = Gaussian(mean, np.diag(std**2 + MEASUREMENT_FLOOR))
        return Moment(time, np.eye(len(mean)), start, start)

    def next(self, last: Moment, time: float, jolt: Array) -> Moment:
        """Later, with nothing measured; `jolt` (f,) is by how much nu' may have changed at the last moment."""
        h, f = time - last.time, self._free
        mean = last.believed.mean.copy()
        heading = mean[2] + h / 2 * float((self._basis @ mean[self._nu])[2])
        turn = body_to_world(heading) @ self._basis
        path = turn @ (h * mean[self._nu] + h**2 / 2 * mean[3 + f :])
        F = np.eye(len(mean))
        F[:3, self._nu], F[:3, 3 + f :] = h * turn, h**2 / 2 * turn
        F[0, 2], F[1, 2] = -path[1], path[0]
        F[self._nu, 3 + f :] = h * np.eye(f)
        mean[self._nu] += h * mean[3 + f :]
        mean[:3] += path
        leap = F[:, 3 + f :] @ jolt
        covariance = F @ last.believed.covariance @ F.T + self._noise(turn, heading, h) + np.outer(leap, leap)
        ahead = Gaussian(mean, symmetric(covariance))
        return Moment(time, F, ahead, ahead)

    def _noise(self, turn: Array, heading: float, h: float) -> Array:
        f = self._free
        powers = [[h**5 / 20, h**4 / 8, h**3 / 6], [h**4 / 8, h**3 / 3, h**2 / 2], [h**3 / 6, h**2 / 2, h]]
        reach = np.eye(3 + 2 * f, 3 * f, f - 3)
        reach[:3, :f] = turn
        noise = JERK**2 * reach @ np.kron(powers, np.eye(f)) @ reach.T
        across = rotation_planar(heading) @ self.cart.rolling.across_b
        noise[:2, :2] += self._sideways**2 * h * np.outer(across, across) + PATH_FLOOR**2 * np.eye(2)
        noise[2, 2] += self.noise.slip**2 * h + PATH_FLOOR**2
        return np.asarray(noise)

    def with_pose(self, moment: Moment, pose: Array) -> Moment:
        known = np.flatnonzero(np.isfinite(pose))
        if not len(known):
            return moment
        residual = pose - moment.believed.mean[:3]
        residual[2] = wrap_angle(residual[2])
        H = np.eye(len(moment.believed.mean))[known]
        return self._with(moment, residual[known], H, self.noise.pose_covariance[np.ix_(known, known)])

    def with_velocity(self, moment: Moment, velocity: Array) -> Moment:
        if not np.isfinite(velocity).all():
            return moment
        to_free = self._project @ body_to_world(moment.believed.mean[2]).T
        H = np.eye(len(moment.believed.mean))[self._nu]
        R = to_free @ self.noise.velocity_covariance @ to_free.T
        return self._with(moment, to_free @ velocity - moment.believed.mean[self._nu], H, R)

    def _with(self, moment: Moment, residual: Array, H: Array, R: Array) -> Moment:
        """Outliers pull, but can't tear."""
        R = R + MEASUREMENT_FLOOR * np.eye(len(R))
        news = innovation(moment.believed, residual, H, R)
        scale = float(news.nis) / (GATE * len(residual))
        if scale > 1.0:
            R = scale * R
            news = innovation(moment.believed, residual, H, R)
        return replace(moment, believed=updated(moment.believed, news, H, R))

    def smoothed(self, moments: list[Moment]) -> Stretch:
        """Each moment with what was measured after it, too."""
        mean = np.array([moment.believed.mean for moment in moments])
        covariance = np.array([moment.believed.covariance for moment in moments])
        ahead = np.array([moment.predicted.mean for moment in moments[1:]]).reshape(-1, mean.shape[1])
        ahead_covariance = np.array([m.predicted.covariance for m in moments[1:]]).reshape(-1, *covariance.shape[1:])
        forth = np.array([moment.transition for moment in moments[1:]]).reshape(-1, *covariance.shape[1:])
        back = np.swapaxes(np.linalg.solve(ahead_covariance, forth @ covariance[:-1]), 1, 2)
        for k in reversed(range(len(back))):
            mean[k] += back[k] @ (mean[k + 1] - ahead[k])
            covariance[k] += back[k] @ (covariance[k + 1] - ahead_covariance[k]) @ back[k].T
        pose, velocity, acceleration = np.split(mean, [3, 3 + self._free], axis=1)
        time = np.array([moment.time for moment in moments])
        return Stretch(time, pose, velocity, acceleration, covariance[:, self._nu, self._nu])
