"""A `CartFilter` beside an observer of what no model explains, which keeps that from the parameters.

What pushes beside the arms is taken for friction, or for another load, by whatever learns from the arms alone. So
samples reach what learns a little late, and without their wrenches where meanwhile something was seen to push: of such
a time the total wrench is not known, and nothing is learned from it. That is so where the disturbance is no noise, and
neither what is not known of the parameters nor a usual load that was put on would look like it, by how the arms and the
cart agree to accelerate. What goes on for too long is the model's error, and is learned from. What is too weak to be
seen, the observer's own deviation for as long as its answer takes, is noise to what learns.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import ClassVar, final

import numpy as np

from cartgrasp.checks import brief, positive
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel
from cartgrasp.motion import Disturbance, Estimate, Measurement
from cartgrasp.tracked_point import TrackedPoint

from ...health import Health
from ...noise import FilterNoise
from ...prior import Prior
from ..cart_filter import CartFilter
from ..given import given
from ..load_change import load_covariance
from ..seen import usable
from ..wrench_sensing import Moving, WrenchSensing
from .observer import DisturbanceObserver, Observed

SLOWEST = 10.0
ANY_SPEED = 1e-9
"""m/s: a least speed makes the filter a regression, which can leave samples out, however exact wrenches are."""
ACTS, STAYS = (10.8, 13.8, 16.3), (3.8, 6.0, 7.8)
"""By dimension, of the normalised square: chi-squared with one, two and three components is beyond the first once in a
thousand times, and beyond the second, below which a disturbance is over, once in twenty."""
PATIENCE = 10.0
"""s after which what pushes is the model's error."""


@final
class DisturbedFilter:
    """Learns as `CartFilter` does, and tells `estimate.disturbance`; its motion is right while something pushes.

    Args:
        cart: Structure and first guess.
        arms: Names of those whose wrenches add up; None: all that are seen.
        noise: Standard deviations of the sensors, in their units; those of `FilterNoise()` unless given.
        prior: How sure the first guess is; `Prior()` and what the cart's file says unless given.
        yaws: Of the contact frames against {b}, rad, by arm; 0 unless given.
        response: s until a push is followed to 5 %; parameters are as much behind.

    Raises:
        UsageError: An argument is of the wrong kind or out of bounds.

    Example:
        >>> import cartgrasp as cg
        >>> from estimation import DisturbedFilter
        >>> cart_filter = DisturbedFilter(cg.load_cart("cart.yaml"))
        >>> for measurement in cg.read_log("run.csv").measurements():
        ...     estimate = cart_filter.update(measurement)
        >>> estimate.disturbance.acts
        False
    """

    tells_disturbance: ClassVar[bool] = True

    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[str] | None = None,
        *,
        noise: FilterNoise | None = None,
        prior: Prior | None = None,
        yaws: Mapping[str, float] | None = None,
        response: float = 0.2,
    ) -> None:
        _, names, self.noise, self.prior, by_arm = given(cart, arms, noise, prior, yaws)
        self.cart, self.arms = cart, names
        self.response = positive("filter: response", response, SLOWEST, "give s")
        self._observer = DisturbanceObserver(cart, self.noise, self.response)
        unseen = max(self.noise.disturbance, self._observer.deviation * math.sqrt(self.response))
        self._learner = CartFilter(
            cart,
            arms,
            noise=replace(self.noise, disturbance=unseen),
            prior=prior,
            yaws=yaws,
            least_speed=ANY_SPEED,
        )
        self._sensing = WrenchSensing(cart, names, by_arm, self.noise.wrench_covariance)
        self._rigid = replace(cart, effects=())
        self._tracked = TrackedPoint(cart.pose_tb)
        self._waiting: deque[Measurement] = deque()
        self._observed: Observed | None = None
        self._disturbance: Disturbance | None = None
        self._is_sure = False
        self._since = self._until = -math.inf  # when the disturbance set in that acts now, and when one acted last

    def __repr__(self) -> str:
        return brief(type(self).__name__, self.cart.name, f"response {self.response:g} s")

    def warm_up(self) -> None:
        self._learner.warm_up()

    def update(self, measurement: Measurement) -> Estimate:
        """Observes to the measurement's time, lets what learns have what is old enough, and says what is known."""
        first = self._observed is None and not self._waiting
        self._waiting.append(measurement)
        told = self._learn(math.inf if first else measurement.time - self.response)
        self._observe(self._tracked.at_body(measurement), told)
        return self._told(told)

    def _learn(self, until: float) -> Estimate:
        """From the samples up to a time."""
        while self._waiting and self._waiting[0].time <= until:
            sample = self._waiting.popleft()
            is_patient = self._until - self._since < PATIENCE
            if is_patient and sample.time <= self._until and sample.wrenches:
                sample = replace(sample, wrenches={arm: np.full(6, np.nan) for arm in sample.wrenches})
            self._learner.update(sample)
        return self._learner.estimate

    def _observe(self, measurement: Measurement, told: Estimate) -> None:
        pose, velocity = (
            np.full(3, np.nan) if part is None else usable(part) for part in (measurement.pose, measurement.velocity)
        )
        observed, theta = self._observed, told.model_parameters
        if observed is None:
            if not np.isfinite(pose).all():
                return
            observed = self._observer.start(measurement.time, pose)
        memory = told.motion.memory if told.motion.memory is not None else np.zeros(0)
        observed = self._observer.advanced(observed, measurement.time, memory, theta)
        observed = self._observer.seen(observed, pose, velocity)
        self._sensing.note_contacts(measurement)
        if measurement.wrenches:
            sensed = self._sensing.sense(measurement, theta, Moving(observed.state(memory), measurement.time))
            if sensed is not None:
                observed = self._observer.pushed(observed, sensed.value, sensed.covariance)
        self._observed = observed
        if self._disturbance is None or np.isfinite(pose).any() or np.isfinite(velocity).any():
            self._conclude(observed, told, memory)

    def _conclude(self, observed: Observed, told: Estimate, memory: Array) -> None:
        """Whether the disturbance acts. It does for sure where no usual load would look like it, and goes on to until a
        load that rolls on could; else where no load would by its inertia."""
        found, time, k = observed.wrench, observed.time, observed.k
        rolls, agreed = np.zeros(k), self._agreed(observed, told, memory)

        def square(rate: Array, cart: CartModel) -> float:
            spread = found.covariance + self._by_load(observed, told, memory, rate, cart)
            return float(found.mean @ np.linalg.solve(spread, found.mean))

        was = self._disturbance is not None and self._disturbance.acts
        begins, stays = ACTS[k - 1], STAYS[k - 1]
        self._is_sure = square(rolls, self.cart) > stays if self._is_sure else square(agreed, self.cart) > begins
        acts = self._is_sure or square(agreed, self._rigid) > (stays if was else begins)
        if acts:
            self._since, self._until = (self._since if was else time), time
        self._disturbance = Disturbance(found.mean, found.covariance, acts)

    def _agreed(self, observed: Observed, told: Estimate, memory: Array) -> Array:
        """The part of nu' (k,) that wrenches alone would make, and that is there: a load does not turn it round."""
        lift = self.cart.planar_wrench(np.eye(observed.k)).T
        alone, whole = (
            self.cart.state_rate(observed.state(memory), lift @ wrench, told.model_parameters, observed.time)[
                self.cart.velocity_slice
            ]
            for wrench in (observed.given, observed.given + observed.wrench.mean)
        )
        return np.where(alone * whole > 0, np.sign(alone) * np.minimum(np.abs(alone), np.abs(whole)), 0.0)

    def _by_load(self, observed: Observed, told: Estimate, memory: Array, rate: Array, cart: CartModel) -> Array:
        """Covariance (k, k) of what parameters that are not known, and a usual load on `cart`, would make of a motion
        with nu' = `rate`."""
        theta, time, state = told.model_parameters, observed.time, observed.state(memory)
        n = 3 + observed.k
        own = (state, theta) if cart is self.cart else (state[:n], theta[:N_PHI])
        by_load = cart.inverse(own[0], rate, own[1], time).by_parameters
        found = by_load @ load_covariance(cart, self.prior, float(theta[0])) @ by_load.T
        if told.covariance is not None:
            by_parameters = self.cart.inverse(state, rate, theta, time).by_parameters
            found = found + by_parameters @ told.covariance @ by_parameters.T
        return np.asarray(found)

    def _told(self, told: Estimate) -> Estimate:
        observed, disturbance = self._observed, self._disturbance
        if observed is None or disturbance is None:
            return told
        is_withheld = told.health == Health.NO_WRENCH and disturbance.acts
        return told._replace(
            time=observed.time,
            motion=observed.motion(told.motion.memory),
            health=Health.OUTLIERS if is_withheld else told.health,
            disturbance=disturbance,
        )
