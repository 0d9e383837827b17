"""Pose, nu and nu' while they happen, from poses and velocities alone: a Kalman filter with white jerk, and its
smoothing over the last moments.

Wrenches stay out: what they are regressed on has then no share in their noise (errors in variables, physics 11). They
say only when there may be a jolt, which white jerk would smooth away.
"""

from __future__ import annotations

import math
from typing import Self

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..gaussian import Gaussian
from ..kernels import tracked_motion as kernels
from ..kernels.filtered_row import Smoothed, drop, smoothed
from ..noise import FilterNoise
from ..shallow import shallow

JERK = 3.0
"""m/s³ √s or rad/s³ √s: root density; high enough that hands which wander smoothly are not smoothed away."""
UNKNOWN = (10.0, 1.0, 3.0)
"""Standard deviations of pose, nu and nu' before anything is measured."""
LEAST_VARIANCE = 1e-10
ROOM = 64
"""Moments that there is room for at first."""


class MotionTracker:
    """Holds the last moments: `(pose, nu, nu')` as predicted from the moment before, and with what was measured."""

    def __init__(self, cart: CartModel, noise: FilterNoise) -> None:
        f = self._free = cart.constraints.n_free
        self._d, self._n = 3 + 2 * f, 0
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
    def blocks(self) -> tuple[Array, Array, Array]:
        """Rows, their times, and constants: for kernels that call `follow`, which then are `followed`."""
        return self._rows, self._time, self._known

    def followed(self, moments: int) -> None:
        """So many are in the rows by now."""
        self._n, self.last_time = moments, float(self._time[moments - 1])

    def make_room(self, moments: int) -> None:
        """For so many."""
        while len(self._time) < moments:
            self._time, self._rows = (np.concatenate([part, np.zeros_like(part)]) for part in (self._time, self._rows))

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
        self.make_room(i + 1)
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

    def smoothed(self, weights: Array) -> Smoothed:
        """The first n moments, each with what was measured after it, too, and without a memory; and the covariances of
        sums by weights (q, n)."""
        return smoothed(self._rows[: self._n], self._time[: self._n], weights, self._known, self._free)

    def is_torn(self, k: int) -> bool:
        """Whether, up to the k-th moment, more samples missed their gate than not: no motion is then known."""
        return kernels.is_torn(self._rows[: k + 1])

    def drop(self, k: int) -> None:
        """The first k moments."""
        drop(self._rows[: self._n], k)
        drop(self._time[: self._n, None], k)
        self._n -= k
        self.first_time = float(self._time[0])
