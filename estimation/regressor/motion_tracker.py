"""Pose, nu and nu' while they happen, from poses and velocities alone: a Kalman filter with white jerk, and its
smoothing over the last moments.

Wrenches stay out: what they are regressed on has then no share in their noise (errors in variables, physics 11). They
say only when there may be a jolt, which white jerk would smooth away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..gaussian import Gaussian
from ..kernels import tracked_motion as kernels
from ..noise import FilterNoise
from ..shallow import shallow

JERK = 3.0
"""m/s³ √s or rad/s³ √s: root density; high enough that hands which wander smoothly are not smoothed away."""
UNKNOWN = (10.0, 1.0, 3.0)
"""Standard deviations of pose, nu and nu' before anything is measured."""
LEAST_VARIANCE = 1e-10
ROOM = 64
"""Moments that there is room for at first."""


@dataclass(frozen=True)
class Stretch:
    """Smoothed moments: time (n,), pose (n, 3), nu (n, f), nu' (n, f), and the covariance of nu (n, f, f); with those
    of sums of nu over the moments (q, f, f)."""

    time: Array
    pose: Array
    velocity: Array
    acceleration: Array
    velocity_covariance: Array
    of_sums: Array


class MotionTracker:
    """Holds the last moments: `(pose, nu, nu')` as predicted from the moment before, and with what was measured."""

    def __init__(self, cart: CartModel, noise: FilterNoise) -> None:
        f = self._free = cart.constraints.n_free
        self._nu, self._d, self._n = slice(3, 3 + f), 3 + 2 * f, 0
        self._known = np.zeros(kernels.known_size(f))
        known = kernels.known_of(self._known, f)
        known.basis[:], known.project[:] = cart.basis_b, np.linalg.pinv(cart.basis_b)
        known.variances[:3], known.variances[3:] = np.diag(noise.pose_covariance), np.diag(noise.velocity_covariance)
        known.across_b[:] = cart.rolling.across_b
        known.densities[:] = JERK**2, noise.sideways(cart) ** 2, noise.slip**2
        self._time, self._rows = np.zeros(ROOM), np.zeros((ROOM, 2 * self._d + 3 * self._d**2 + 1))
        self.first_time = self.last_time = -math.inf

    @property
    def time(self) -> Array:
        """Of the moments (n,)."""
        return self._time[: self._n]

    @property
    def now(self) -> Gaussian:
        """What is believed of the last moment."""
        last = kernels.moment(self._rows[self._n - 1], self._d)
        return Gaussian(last.mean.copy(), last.covariance.copy())

    def start(self, time: float, pose: Array) -> None:
        """Anew, with a pose that may be NaN in parts."""
        known = np.isfinite(pose)
        variance = np.square(np.repeat(UNKNOWN, [3, self._free, self._free]))
        variance[:3] = np.where(known, kernels.known_of(self._known, self._free).variances[:3], variance[:3])
        first = kernels.moment(self._rows[0], self._d)
        first.mean[:3], first.mean[3:] = np.where(known, pose, 0.0), 0.0
        first.covariance[:], first.worst[:] = np.diag(variance + LEAST_VARIANCE), math.nan
        self._n, self._time[0] = 1, time
        self.first_time = self.last_time = time

    def next(self, time: float, jolt: Array, seen: Array) -> None:
        """A later moment, with what was `seen` (6,): pose and velocity, NaN where missing; `jolt` (f,) is by how much
        nu' may have changed at the last one."""
        i = self._n
        if i == len(self._time):
            self._make_room()
        kernels.follow(self._rows, i, time - self.last_time, self._known, seen, jolt)
        self._n, self._time[i], self.last_time = i + 1, time, time

    def take(self, seen: Array) -> None:
        """Measured at the last moment, too."""
        kernels.take(self._rows, self._n - 1, self._known, seen, self._free)

    def copy(self) -> Self:
        other = shallow(self)
        other._time, other._rows = self._time.copy(), np.empty_like(self._rows)
        other._rows[: self._n] = self._rows[: self._n]
        return other

    def smoothed(self, weights: Array) -> Stretch:
        """The first n moments, each with what was measured after it, too; and the covariances of sums by weights
        (q, n)."""
        q, end = weights.shape
        n, d, nu = self._n, self._d, self._nu
        mean, covariance, sums = np.empty((n, d)), np.empty((n, d, d)), np.empty((2, q, d, d))
        whole = np.zeros((q, n))
        whole[:, :end] = weights
        kernels.smooth(self._rows, mean, covariance, whole, sums, self._known)
        pose, velocity, acceleration = np.split(mean[:end], [3, 3 + self._free], axis=1)
        return Stretch(
            self._time[:end].copy(), pose, velocity, acceleration, covariance[:end, nu, nu], sums[0][:, nu, nu]
        )

    def is_torn(self, k: int) -> bool:
        """Whether, up to the k-th moment, more samples missed their gate than not: no motion is then known."""
        missed = self._rows[: k + 1, -1]
        return int((missed > 1.0).sum()) * 2 > int(np.isfinite(missed).sum())

    def drop(self, k: int) -> None:
        """The first k moments."""
        for part in (self._time, self._rows):
            part[: self._n - k] = part[k : self._n].copy()
        self._n -= k
        self.first_time = float(self._time[0])

    def _make_room(self) -> None:
        self._time, self._rows = (np.concatenate([part, np.zeros_like(part)]) for part in (self._time, self._rows))
