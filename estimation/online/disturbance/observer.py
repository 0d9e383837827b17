"""A wrench that no model explains, from how the cart moves: a Kalman filter over pose, nu and that wrench d.

`Mr nu' = Sᵀ(wrench_b + effects) - Cr nu + d`, and d is a random walk (Friedland 1969). Of one direction with mass m,
whose velocity is measured with density r, the filter is an observer with the poles of a Butterworth filter of

    w² = walk / (m √r),    d's variance √2 m² w³ r,    answer to a step 1 - √2 exp(-w t/√2) sin(w t/√2 + π/4),

which stays within 5 % from `w t = 2.93` on. So the walk follows from how quick the answer shall be; poses make it a
little quicker. Surprising samples in a row that a push could have made, since before the first of them, are no
outliers, but one that sets in, or is over: then d may be any such, and is known as soon as the noise of the sensors
allows. No push moves a pose while the velocity stays: then its source has moved (`kernels/relocalisation.py`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel
from cartgrasp.motion import Disturbance, Motion

from ...gaussian import Gaussian
from ...noise import FilterNoise
from ...prior import Prior
from ..first_motion import MAX_TRACKING_GAP, first_motion
from ..kernels import observed_motion
from ..kernels import observed_wrench as kernels
from ..kernels.observed_wrench import MAX_OBSERVER_STEP, Constants
from ..load_change import load_covariance

NORMALISED_SETTLING_TIME = 2.93
"""The value of w t from which on the answer to a step is within 5 % of it."""
PUSH_FORCE_STD = 40.0
"""N: a standard deviation of what may set in at once; moments by the noise's lever."""
MIN_OBSERVER_VELOCITY_NOISE = 5e-4
NOMINAL_SAMPLE_PERIOD = 0.01


@dataclass(frozen=True, eq=False)
class Observed:
    """Belief of pose, nu and d (3 + 2 k,) at `time` (s); the reduced wrench `given` (k,) from then on with the
    covariance of its noise; how many samples in a row have surprised, and the time of the last one that did not; and
    the `source` of poses (7,), as `kernels/observed_motion.py` has it."""

    time: float
    belief: Gaussian
    given: Array
    given_noise: Array
    surprised: int = 0
    calm: float = -math.inf
    source: Array = field(default_factory=lambda: np.array([0.0, 0.0, 0.0, math.inf, -math.inf, -math.inf, 0.0]))

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


# Many methods: what kernels are given about one cart, each worked out once.
@dataclass(frozen=True)
class DisturbanceObserver:
    """Steps from one `Observed` to the next; `response` (s) is the time in which a step is followed to 5 %, `prior`
    says where a usual load may stand."""

    cart: CartModel
    noise: FilterNoise
    response: float
    prior: Prior

    def start(self, time: float, pose: Array) -> Observed:
        """The belief of a cart at rest, with a pose (3,) that is finite."""
        k = self.cart.constraints.n_free
        mean, variances = first_motion(self.cart, self.noise, pose)
        covariance = np.diag(np.concatenate([variances[: 3 + k], self._usual]))
        return Observed(
            time, Gaussian(np.append(mean[: 3 + k], np.zeros(k)), covariance), np.zeros(k), np.eye(k), calm=time
        )

    def pushed(self, observed: Observed, wrench: Array, noise: Array) -> Observed:
        """The observed state, pushed by this reduced wrench (k,) of the arms from now on."""
        return replace(observed, given=wrench, given_noise=noise)

    def forgotten(self, observed: Observed) -> Observed:
        """The motion as it was observed, and of d no more than at first."""
        mean, covariance, own = observed.belief.mean.copy(), observed.belief.covariance.copy(), 3 + observed.k
        mean[own:] = covariance[own:] = covariance[:, own:] = 0.0
        covariance[own:, own:] = np.diag(self._usual)
        return replace(observed, belief=Gaussian(mean, covariance), surprised=0, calm=observed.time)

    def advanced(self, observed: Observed, time: float, memory: Array, theta: Array) -> Observed:
        """The observed state at a later time (s), with what effects remember and parameters (p,) as they are believed
        to be."""
        gap = time - observed.time
        if not gap > 0.0:
            return observed
        if gap > MAX_TRACKING_GAP:
            return replace(self.start(time, observed.belief.mean[:3]), given=observed.given)
        belief = observed.belief.mean.copy(), observed.belief.covariance.copy()
        if self._in_kernels:
            push, known = (observed.given, observed.given_noise), (theta, memory, self.cart.inertia.mass)
            dynamics, span = self.cart.dynamics, (observed.time, time)
            kernels.advance(dynamics.floats, dynamics.ints, self._constants, belief, push, known, span, self._room)
        else:
            self._go(observed, belief, gap, (memory, theta))
        return replace(observed, time=time, belief=Gaussian(*belief))

    def seen(self, observed: Observed, pose: Array, velocity: Array) -> Observed:
        """The observed state updated by a pose (3,) and a velocity (3,) in {s}, NaN where they are missing."""
        belief = observed.belief.mean.copy(), observed.belief.covariance.copy()
        surprises, source = (observed.surprised, observed.time - observed.calm, observed.time), observed.source.copy()
        now = observed_motion.see(self._constants, belief, (pose, velocity), surprises, source, self._room)
        if now < 0:
            return observed
        goes_on = now > 1 or (now == 1 and observed.surprised == 0)
        calm = observed.calm if goes_on else observed.time
        return replace(observed, belief=Gaussian(*belief), surprised=now, calm=calm, source=source)

    def squares(
        self, observed: Observed, memory: Array, theta: Array, unknown: Array | None
    ) -> tuple[tuple[float, float, float], Array]:
        """Normalised squares of d as `kernels.squares` has them, and the covariance (k, k) of d for the motion that
        there is; `unknown` (p, p) is what is not known of the parameters (p,)."""
        cart, k, state = self.cart, observed.k, observed.state(memory)
        rates, found = np.full((2, k), np.nan), np.empty((k, k))
        if not self._in_kernels:
            given = np.stack([observed.given, observed.given + observed.wrench.mean]) @ self._constants.lift.T
            rates[:] = cart.state_rate(state, given, theta, observed.time)[:, cart.velocity_slice]
        foreign = cart.foreign_sums(state, theta, observed.time)
        known = theta, np.zeros((0, 0)) if unknown is None else unknown, memory, foreign, observed.time
        belief, dynamics = (observed.belief.mean, observed.belief.covariance), cart.dynamics
        blocks = dynamics.floats, dynamics.ints, self._constants
        return kernels.squares(*blocks, belief, observed.given, known, (rates, found), self._room), found

    @property
    def unknown(self) -> Disturbance:
        """What is told of d where nobody knows what the arms do."""
        return Disturbance(np.zeros(len(self._usual)), np.diag(self._usual), False)

    @property
    def deviation(self) -> float:
        """Standard deviation (N) of d along its first direction, in closed form, for samples every 10 ms and the first
        guess."""
        root = math.sqrt(NOMINAL_SAMPLE_PERIOD) * self._heard[0] * (NORMALISED_SETTLING_TIME / self.response) ** 1.5
        return float(2**0.25 * self._inertias[0] * root)

    # --- a step -----------------------------------------------------------------------------------------------

    def _go(self, observed: Observed, belief: tuple[Array, Array], gap: float, known: tuple[Array, Array]) -> None:
        """What `kernels.advance` does, of effects without kernels."""
        cart, k, (memory, theta) = self.cart, observed.k, known
        count = math.ceil(gap / MAX_OBSERVER_STEP - 1e-6)
        for i in range(count):
            state, given = np.concatenate([belief[0][: 3 + k], memory]), observed.given + belief[0][3 + k :]
            rate = cart.rate(state, self._constants.lift @ given, theta, observed.time + i * gap / count)
            flow = np.concatenate([part.ravel() for part in (rate.value, rate.by_state, rate.by_wrench)])
            numbers = len(state), gap / count, float(theta[0] / cart.inertia.mass)
            kernels.predict(self._constants, belief, observed.given_noise, flow, numbers, self._room)

    @property
    def _in_kernels(self) -> bool:
        return self.cart.is_compiled and not self.cart.slip_compliance

    @cached_property
    def _room(self) -> Array:
        k = self.cart.constraints.n_free
        return np.zeros(kernels.room_for(len(self.cart.state_names), len(self.cart.parameters), k))

    @cached_property
    def _constants(self) -> Constants:
        cart, noise = self.cart, self.noise
        return Constants(
            lift=np.ascontiguousarray(cart.rolling.along_b.T),
            basis=np.ascontiguousarray(cart.basis_b),
            project=np.ascontiguousarray(self._to_free),
            pose=np.array(noise.pose_covariance),
            velocity=np.array(noise.velocity_covariance),
            walk=self._inertias * (NORMALISED_SETTLING_TIME / self.response) ** 2 * self._heard,
            usual=self._usual,
            inertias=self._inertias,
            disturbance=(np.array([1.0, 1.0, noise.lever]) * noise.disturbance) ** 2,
            creep=noise.sideways(cart) * np.array(cart.rolling.across_b),
            slip=np.array([noise.slip**2]),
            load=np.ascontiguousarray(load_covariance(cart, self.prior, 1.0)[:N_PHI, :N_PHI]),
        )

    @cached_property
    def _usual(self) -> Array:
        """Variances (k,) of what may set in."""
        return np.asarray((PUSH_FORCE_STD * self.noise.wrench_scale(self.cart)) ** 2)

    @cached_property
    def _inertias(self) -> Array:
        """(k,), kg and kg m²."""
        whole = np.diag(self.cart.inertia.phi[[0, 0, 3]])
        return np.asarray(np.diagonal(self.cart.basis_b.T @ whole @ self.cart.basis_b))

    @cached_property
    def _heard(self) -> Array:
        """Standard deviations (k,) of measured velocities."""
        variances = np.diagonal(self._to_free @ self.noise.velocity_covariance @ self._to_free.T)
        return np.maximum(np.sqrt(variances), MIN_OBSERVER_VELOCITY_NOISE)

    @cached_property
    def _to_free(self) -> Array:
        return np.asarray(np.linalg.pinv(self.cart.basis_b))
