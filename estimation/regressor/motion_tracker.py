"""Pose, nu and nu' while they happen, from poses and velocities alone: a Kalman filter with white jerk, and its
smoothing over the last moments.

Wrenches stay out: what they are regressed on has then no share in their noise (errors in variables, physics 11). They
say only when there may be a jolt, which white jerk would smooth away.
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..gaussian import Gaussian
from ..kernels import tracked_motion as kernels
from ..noise import FilterNoise

JERK = 3.0
"""m/s³ √s or rad/s³ √s: root density; high enough that hands which wander smoothly are not smoothed away."""
UNKNOWN = (10.0, 1.0, 3.0)
"""Standard deviations of pose, nu and nu' before anything is measured."""
LEAST_VARIANCE = 1e-10
NOTHING = np.full(3, np.nan)
ROOM = 64
"""Moments that there is room for at first."""


Rows = tuple[Array, Array, Array, Array, Array]
"""Of moments: transition from the one before (n, d, d), mean (n, d) and covariance (n, d, d) as predicted, and the same
two as believed."""


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
    """Holds the last moments: `(pose, nu, nu')` as predicted from the moment before, and with what was measured."""

    def __init__(self, cart: CartModel, noise: FilterNoise) -> None:
        self._noise, self._free = noise, cart.constraints.n_free
        self._nu = slice(3, 3 + self._free)
        basis = np.ascontiguousarray(cart.basis_b)
        self._wheels = basis, np.array(cart.rolling.across_b, dtype=float)
        self._project = np.ascontiguousarray(np.linalg.pinv(basis))
        self._variances = np.diag(noise.pose_covariance).copy(), np.diag(noise.velocity_covariance).copy()
        self._densities = JERK**2, noise.sideways(cart) ** 2, noise.slip**2
        d, self._n = 3 + 2 * self._free, 0
        self._time = np.zeros(ROOM)
        self._rows: Rows = (
            np.zeros((ROOM, d, d)),
            *(np.zeros((ROOM, d)), np.zeros((ROOM, d, d))),
            *(np.zeros((ROOM, d)), np.zeros((ROOM, d, d))),
        )

    @property
    def time(self) -> Array:
        """Of the moments (n,)."""
        return self._time[: self._n]

    @property
    def last_time(self) -> float:
        """Minus infinity before the first."""
        return float(self._time[self._n - 1]) if self._n else -math.inf

    @property
    def now(self) -> Gaussian:
        """What is believed of the last moment."""
        return Gaussian(self._rows[3][self._n - 1].copy(), self._rows[4][self._n - 1].copy())

    def start(self, time: float, pose: Array) -> None:
        """Anew, with a pose that may be NaN in parts."""
        known = np.isfinite(pose)
        mean = np.zeros(3 + 2 * self._free)
        mean[:3] = np.where(known, pose, 0.0)
        variance = np.square(np.repeat(UNKNOWN, [3, self._free, self._free]))
        variance[:3] = np.where(known, self._variances[0], variance[:3])
        self._n, self._time[0] = 1, time
        self._rows[3][0], self._rows[4][0] = mean, np.diag(variance + LEAST_VARIANCE)

    def next(self, time: float, jolt: Array) -> None:
        """A later moment, with nothing measured; `jolt` (f,) is by how much nu' may have changed at the last one."""
        i = self._n
        if i == len(self._time):
            self._make_room()
        kernels.follow(self._rows, i, time - self._time[i - 1], self._wheels, self._densities, jolt)
        self._time[i] = time
        self._n = i + 1

    def take(self, pose: Array | None, velocity: Array | None) -> None:
        """Measured at the last moment, NaN where missing."""
        seen = (
            NOTHING if pose is None else np.array(pose, dtype=float),
            NOTHING if velocity is None else np.array(velocity, dtype=float),
        )
        kernels.take(self._rows, self._n - 1, seen, self._variances, self._project)

    def copy(self) -> Self:
        other = copy.copy(self)
        a, b, c, d, e = (part.copy() for part in self._rows)
        other._time, other._rows = self._time.copy(), (a, b, c, d, e)
        return other

    def smoothed(self) -> Stretch:
        """Each moment with what was measured after it, too."""
        n, d = self._n, 3 + 2 * self._free
        mean, covariance = np.empty((n, d)), np.empty((n, d, d))
        kernels.smooth(self._rows, mean, covariance)
        pose, velocity, acceleration = np.split(mean, [3, 3 + self._free], axis=1)
        return Stretch(self.time.copy(), pose, velocity, acceleration, covariance[:, self._nu, self._nu])

    def drop(self, k: int) -> None:
        """The first k moments."""
        for part in (self._time, *self._rows):
            part[: self._n - k] = part[k : self._n].copy()
        self._n -= k

    def _make_room(self) -> None:
        self._time = np.concatenate([self._time, np.zeros_like(self._time)])
        a, b, c, d, e = (np.concatenate([part, np.zeros_like(part)]) for part in self._rows)
        self._rows = a, b, c, d, e
