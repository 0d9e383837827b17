"""Pose, nu and nu' while they happen, from poses and velocities alone: a Kalman filter with white jerk, and its
smoothing over the last moments.

Wrenches stay out: what they are regressed on has then no share in their noise (errors in variables, physics.md). They
are kept beside it, and say only when there may be a jolt, which white jerk would smooth away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.shallow_copy import shallow_copy

from ...gaussian import Gaussian
from ...noise import FilterNoise
from ..kernels import tracked_motion as kernels
from ..kernels.measured_wrench import size
from ..kernels.recorded_moment import NEW_MOMENT, record
from ..kernels.row_algebra import SMOOTHING_LAG, Smoothed, over

JERK_DENSITY = 3.0
"""m/s³ √s or rad/s³ √s: root density; high enough that hands which wander smoothly are not smoothed away."""
INITIAL_STDS = (10.0, 1.0, 3.0)
"""Standard deviations of pose, nu and nu' before anything is measured."""
MIN_INITIAL_VARIANCE = 1e-10
INITIAL_CAPACITY = 64
"""Moments that there is room for at first."""


@dataclass(frozen=True)
class Smoothing:
    """Moments on their way to be smoothed, the last ones first: times, means and covariances (n, ...), of which the
    first `left` are not there yet; and the covariances of sums by weights (q, m), with what is carried on."""

    time: Array
    weights: Array
    means: Array
    covariances: Array
    sums: Array
    left: int

    @property
    def smoothed(self) -> Smoothed:
        """The first m moments, each with what was measured after it, too, and without a memory; and the covariances of
        the sums."""
        m, f = self.weights.shape[1], self.sums.shape[2]
        mean, nu, none = self.means[:m], slice(3, 3 + f), np.zeros((m, 0))
        return Smoothed(
            time=self.time[:m],
            pose=mean[:, :3].copy(),
            velocity=mean[:, nu].copy(),
            acceleration=mean[:, 3 + f :].copy(),
            covariance=self.covariances[:m, nu, nu].copy(),
            of_sums=self.sums[:, :f].copy(),
            memory=none,
            memory_std=none,
        )


# Many methods: the one owner of a ring of moments that kernels write; nobody else touches it.
class MotionTracker:
    """Holds the last moments: `(pose, nu, nu')` as predicted from the moment before, and with what was measured; and
    the wrench of each."""

    def __init__(self, cart: CartModel, noise: FilterNoise) -> None:
        f = self._n_free = cart.constraints.n_free
        self._d, self._wrench_size, self._n = 3 + 2 * f, size(f, len(cart.parameters)), 0
        self._known = np.zeros(kernels.known_size(f))
        known = kernels.known_of(self._known, f)
        known.basis[:], known.project[:] = cart.basis_b, np.linalg.pinv(cart.basis_b)
        known.variances[:3], known.variances[3:] = np.diag(noise.pose_covariance), np.diag(noise.velocity_covariance)
        known.across_b[:] = cart.rolling.across_b
        known.densities[:] = JERK_DENSITY**2, noise.sideways(cart) ** 2, noise.slip**2
        self._rows = np.zeros((INITIAL_CAPACITY, 1 + self._wrench_size + kernels.row_size(self._d)))
        self._past_wrenches, self.last_time = np.zeros((0, 1 + self._wrench_size)), -math.inf

    @property
    def time(self) -> Array:
        """Times of the moments (n,), s."""
        return self._rows[: self._n, 0].copy()

    @property
    def blocks(self) -> tuple[Array, Array]:
        """Rows and constants: for kernels that record more moments, which `note_moments` then hears of."""
        return self._rows, self._known

    def note_moments(self, moments: int) -> None:
        """Notes that so many moments are in the rows by now."""
        self._n, self.last_time = moments, float(self._rows[moments - 1, 0])

    def make_room(self, moments: int) -> None:
        """Makes room for so many moments."""
        while len(self._rows) < moments:
            self._rows = np.concatenate([self._rows, np.zeros_like(self._rows)])

    @property
    def now(self) -> Gaussian:
        """What is believed of the last moment."""
        last = kernels.moment(self._rows[self._n - 1], self._d)
        return Gaussian(last.mean.copy(), last.covariance.copy())

    def start(self, time: float, pose: Array) -> None:
        """Begins anew, with a pose that may be NaN in parts."""
        known, first = np.isfinite(pose), self._rows[0]
        variance = np.square(np.repeat(INITIAL_STDS, [3, self._n_free, self._n_free]))
        variance[:3] = np.where(known, kernels.known_of(self._known, self._n_free).variances[:3], variance[:3])
        first[:], first[0], first[1] = 0.0, time, math.nan
        moment = kernels.moment(first, self._d)
        moment.mean[:3] = np.where(known, pose, 0.0)
        moment.covariance[:], moment.worst[:] = np.diag(variance + MIN_INITIAL_VARIANCE), math.nan
        self._n, self.last_time, self._past_wrenches = 1, time, np.zeros((0, 1 + self._wrench_size))

    def record(self, time: float, seen: Array, wrenches: Array, grip: Array, believed: Array) -> int:
        """A sample of the last moment, or of a later one: pose and velocity `seen` (6,), NaN where missing; the arms'
        wrenches (6 n,), if any, and the rest of `measured_wrench.MeasuredWrench`. Returns what `recorded_moment.py`
        says of it."""
        n = self._n
        if n == len(self._rows):
            self.make_room(n + 1)
        said = record(self._rows, self._known, n, time, seen, wrenches, grip, believed)
        if said & NEW_MOMENT:
            self._n, self.last_time = n + 1, time
        return said

    def scale_noise(self, variances: Array) -> None:
        """Sets the variances of velocities (3,) from now on."""
        kernels.known_of(self._known, self._n_free).variances[3:] = variances

    @property
    def measured_wrench(self) -> Array:
        """The last moment's row, from the wrench on."""
        return self._rows[self._n - 1, 1:]

    def wrenches(self, k: int, late: float) -> tuple[Array, float]:
        """The wrenches of the first k moments, (k, width), as in `measured_wrench.py`, if they were recorded so late
        (s), as far as there are any; and how much later their samples are in the mean than the ones of the moments."""
        here = self._rows[: self._n, : 1 + self._wrench_size]
        rows, time = np.concatenate([self._past_wrenches, here]), here[:, 0]
        late = min(max(late, rows[0, 0] - time[0]), time[-1] - time[k - 1])
        halfway = (rows[:-1, 0] + rows[1:, 0]) / 2
        found = rows[np.searchsorted(halfway, time[:k] + late), 1:]
        lasting = time[1 : k + 1] - time[:k]
        return found, float(((found[:, 0] - here[:k, 1]) * lasting).sum() / lasting.sum())

    def copy(self) -> Self:
        other = shallow_copy(self)
        other._rows = np.empty_like(self._rows)
        other._rows[: self._n] = self._rows[: self._n]
        return other

    def over(self) -> tuple[int, int]:
        """For the block that has been over for long enough: how many moments come before the next, and how many it has.
        Both are 0 where there is none."""
        return over(self._rows[: self._n])

    def smoothing(self, weights: Array) -> Smoothing:
        """Begins to smooth all moments, with covariances of sums of the first m by weights (q, m)."""
        n, d, f = self._n, self._d, self._n_free
        sums = np.zeros((len(weights), f + d, f))
        return Smoothing(self.time, weights, np.empty((n, d)), np.empty((n, d, d)), sums, n)

    def smoothed_on(self, smoothing: Smoothing, moments: int) -> Smoothing:
        """So many moments more; it has to be before any are dropped."""
        first, sums = max(smoothing.left - moments, 0), smoothing.sums.copy()
        found = smoothing.means, smoothing.covariances
        span = first, smoothing.left
        kernels.smooth(self._rows[: len(smoothing.time)], found, smoothing.weights, sums, self._known, span)
        return replace(smoothing, sums=sums, left=first)

    def is_torn(self, k: int) -> bool:
        """Whether, up to the k-th moment, more samples missed their gate than not: no motion is then known."""
        missed = self._rows[: k + 1, -1]
        return bool(2 * np.count_nonzero(missed > 1.0) > np.count_nonzero(np.isfinite(missed)))

    @property
    def seen_until(self) -> float:
        """Time of the last moment at which a pose or a velocity came, s."""
        seen = np.flatnonzero(np.isfinite(self._rows[: self._n, -1]))
        return float(self._rows[seen[-1], 0]) if len(seen) else -math.inf

    def drop(self, k: int) -> None:
        """The first k moments, of which wrenches are kept that may come early."""
        past = np.concatenate([self._past_wrenches, self._rows[:k, : 1 + self._wrench_size]])
        self._past_wrenches = past[past[:, 0] > self._rows[k, 0] - SMOOTHING_LAG]
        self._rows[: self._n - k] = self._rows[k : self._n]
        self._n -= k
