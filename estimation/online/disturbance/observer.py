"""A wrench that no model explains, from how the cart moves: a Kalman filter over pose, nu and that wrench d.

`Mr nu' = Sᵀ(wrench_b + effects) - Cr nu + d`, and d is a random walk (Friedland 1969). Of one direction with mass m,
whose velocity is measured with density r, the filter is an observer with the poles of a Butterworth filter of

    w² = walk / (m √r),    d's variance √2 m² w³ r,    answer to a step 1 - √2 exp(-w t/√2) sin(w t/√2 + π/4),

which stays within 5 % from `w t = 2.93` on. So the walk follows from how quick the answer shall be; poses make it a
little quicker. Two surprising samples in a row that a usual push could have made are no outliers, but one that sets
in: then d may be any such, and is known as soon as the noise of the sensors allows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cartgrasp.frames import Array, body_to_world, rotation_planar, wrap_angle
from cartgrasp.model import CartModel
from cartgrasp.motion import Motion

from ...gaussian import Gaussian
from ...noise import FilterNoise
from ..first_motion import LOST_AFTER, first_motion
from .filtering import exponential_step, innovation, predicted, updated

SETTLED = 2.93
"""The value of w t from which on the answer to a step is within 5 % of it."""
USUAL_PUSH = 40.0
"""N: a standard deviation of what may set in at once; moments by the noise's lever."""
SURPRISING = 20.5
"""Normalised square of pose and velocity from which a sample surprises: five numbers of white noise are beyond it once
in a thousand times."""
LEAST_VELOCITY_NOISE = 5e-4
MAX_STEP, USUAL_PERIOD = 0.02, 0.01
FARTHEST = 1e9


@dataclass(frozen=True, eq=False)
class Observed:
    """Belief of pose, nu and d (3 + 2 k,) at `time` (s); the reduced wrench `given` (k,) from then on with the
    covariance of its noise; and how many samples in a row have surprised."""

    time: float
    belief: Gaussian
    given: Array
    given_noise: Array
    surprised: int = 0

    @property
    def k(self) -> int:
        return len(self.given)

    @property
    def wrench(self) -> Gaussian:
        """d, (k,)."""
        part = slice(3 + self.k, None)
        return Gaussian(self.belief.mean[part], self.belief.covariance[part, part])

    def state(self, memory: Array) -> Array:
        """The state of the cart, with what effects remember."""
        return np.concatenate([self.belief.mean[: 3 + self.k], memory])

    def motion(self, memory: Array | None = None) -> Motion:
        mean = self.belief.mean
        return Motion(mean[:3].copy(), mean[3 : 3 + self.k].copy(), memory)


@dataclass(frozen=True)
class DisturbanceObserver:
    """Steps from one `Observed` to the next; `response` (s) is the time in which a step is followed to 5 %."""

    cart: CartModel
    noise: FilterNoise
    response: float

    def start(self, time: float, pose: Array) -> Observed:
        """The belief of a cart at rest, with a pose (3,) that is finite."""
        k = self.cart.constraints.n_free
        mean, variances = first_motion(self.cart, self.noise, pose)
        covariance = np.diag(np.concatenate([variances[: 3 + k], self._usual]))
        return Observed(time, Gaussian(np.append(mean[: 3 + k], np.zeros(k)), covariance), np.zeros(k), np.eye(k))

    def pushed(self, observed: Observed, wrench: Array, noise: Array) -> Observed:
        """The observed state, pushed by this reduced wrench (k,) of the arms from now on."""
        return replace(observed, given=wrench, given_noise=noise)

    def advanced(self, observed: Observed, time: float, memory: Array, theta: Array) -> Observed:
        """The observed state at a later time (s), with what effects remember and parameters (p,) as they are believed
        to be."""
        gap = time - observed.time
        if not gap > 0.0:
            return observed
        if gap > LOST_AFTER:
            return replace(self.start(time, observed.belief.mean[:3]), given=observed.given)
        count = math.ceil(gap / MAX_STEP - 1e-6)
        for _ in range(count):
            observed = self._step(observed, gap / count, memory, theta)
        return observed

    def seen(self, observed: Observed, pose: Array, velocity: Array) -> Observed:
        """The observed state updated by a pose (3,) and a velocity (3,) in {s}, NaN where they are missing."""
        residual, rows, noise = self._measured(observed, pose, velocity)
        known = np.isfinite(residual) & (np.abs(residual) < FARTHEST)
        if not known.any():
            return observed
        residual, rows, noise = residual[known], rows[known], noise[np.ix_(known, known)]
        belief = observed.belief
        square = float(innovation(belief, residual, rows, noise).nis)
        surprised = observed.surprised + 1 if square > SURPRISING else 0
        if surprised > 1:
            belief = self._opened(belief, observed.k)
            square = float(innovation(belief, residual, rows, noise).nis)
            belief = belief if square <= SURPRISING else observed.belief
        if square > SURPRISING:
            noise = noise * square / SURPRISING
        found = updated(belief, innovation(belief, residual, rows, noise), rows, noise)
        return replace(observed, belief=found, surprised=surprised)

    def _opened(self, belief: Gaussian, k: int) -> Gaussian:
        """Something set in, about a sample ago."""
        covariance, nu = belief.covariance.copy(), np.arange(3, 3 + k)
        covariance[nu + k, nu + k] = np.maximum(covariance[nu + k, nu + k], self._usual)
        covariance[nu, nu] += self._usual * (MAX_STEP / self._inertias) ** 2
        return Gaussian(belief.mean, covariance)

    @property
    def deviation(self) -> float:
        """Standard deviation (N) of d along its first direction, in closed form, for samples every 10 ms and the first
        guess."""
        root = math.sqrt(USUAL_PERIOD) * self._heard[0] * (SETTLED / self.response) ** 1.5
        return float(2**0.25 * self._inertias[0] * root)

    # --- a step -----------------------------------------------------------------------------------------------

    @cached_property
    def _usual(self) -> Array:
        """Variances (k,) of what may set in."""
        return np.asarray((USUAL_PUSH * self.noise.wrench_scale(self.cart)) ** 2)

    @cached_property
    def _inertias(self) -> Array:
        """(k,), kg and kg m²."""
        whole = np.diag(self.cart.inertia.phi[[0, 0, 3]])
        return np.asarray(np.diagonal(self.cart.basis_b.T @ whole @ self.cart.basis_b))

    def _walk(self, theta: Array, step: float) -> Array:
        """Variance (k,) that d gains in a step between samples."""
        share = theta[0] / self.cart.inertia.mass
        return np.asarray((share * self._inertias * (SETTLED / self.response) ** 2 * self._heard * step) ** 2)

    @cached_property
    def _heard(self) -> Array:
        """Standard deviations (k,) of measured velocities."""
        variances = np.diagonal(self._to_free @ self.noise.velocity_covariance @ self._to_free.T)
        return np.maximum(np.sqrt(variances), LEAST_VELOCITY_NOISE)

    @cached_property
    def _to_free(self) -> Array:
        return np.asarray(np.linalg.pinv(self.cart.basis_b))

    def _step(self, observed: Observed, step: float, memory: Array, theta: Array) -> Observed:
        cart, k, mean = self.cart, observed.k, observed.belief.mean
        lift = cart.planar_wrench(np.eye(k)).T
        flow = cart.rate(observed.state(memory), lift @ (observed.given + mean[3 + k :]), theta, observed.time)
        n, moved, walk = 3 + 2 * k, slice(3 + k), np.arange(3 + k, 3 + 2 * k)
        jacobian, rate, density = np.zeros((n, n)), np.zeros(n), np.zeros((n, n))
        reach = flow.by_wrench[moved] @ lift
        jacobian[moved, moved], jacobian[moved, walk], rate[moved] = (
            flow.by_state[moved, moved],
            reach,
            flow.value[moved],
        )
        density[moved, moved] = reach @ observed.given_noise @ reach.T * step + self._drift(
            mean[2], flow.by_wrench[moved]
        )
        density[walk, walk] = self._walk(theta, step) / step
        belief = predicted(observed.belief, exponential_step(rate, jacobian, density, step))
        return replace(observed, time=observed.time + step, belief=belief)

    def _drift(self, heading: float, by_wrench: Array) -> Array:
        """Density of what white forces and wheels that creep do."""
        noise, cart = self.noise, self.cart
        white = by_wrench * np.array([1.0, 1.0, noise.lever]) * noise.disturbance
        found = white @ white.T
        sideways = rotation_planar(heading) @ cart.rolling.across_b
        found[:2, :2] += noise.sideways(cart) ** 2 * np.outer(sideways, sideways)
        found[2, 2] += noise.slip**2
        return np.asarray(found)

    def _measured(self, observed: Observed, pose: Array, velocity: Array) -> tuple[Array, Array, Array]:
        """Residuals, rows and noise of pose and of the velocity in the free directions."""
        k, mean, noise = observed.k, observed.belief.mean, self.noise
        to_free = self._to_free @ body_to_world(mean[2]).T
        off = np.where(np.abs(pose) < FARTHEST, pose, np.nan) - mean[:3]
        off[2] = wrap_angle(off[2]) if np.isfinite(off[2]) else np.nan
        residual = np.append(off, to_free @ velocity - mean[3 : 3 + k])
        covariance = np.zeros((3 + k, 3 + k))
        covariance[:3, :3], covariance[3:, 3:] = noise.pose_covariance, to_free @ noise.velocity_covariance @ to_free.T
        return residual, np.eye(3 + k, len(mean)), covariance + 1e-12 * np.eye(3 + k)
