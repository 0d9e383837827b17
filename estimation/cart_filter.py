"""The online filter: motion that the recorded wrench drives, and parameters that a regression on motion learns.

An augmented EKF (8)-(20) takes noise of the wrench that drives it for motion that it did not make, and learns a mass
that is too large, too surely (errors in variables, physics 11). So the two are kept apart. Parameters are learned by
`ParameterLearner`, whose rows have the wrench's noise on one side; motion is a Kalman filter that the recorded wrench
drives, with what is not known of wrench and parameters in its covariance, and no gain of its own on the latter
(Schmidt 1966). Where a new estimate of the parameters takes the motion, its slopes by them tell.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from cartgrasp.errors import UsageError
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement

from .driven_motion import DrivenMotion
from .gaussian import Gaussian
from .health import Health
from .noise import FilterNoise
from .prior import Prior
from .regressor.parameter_learner import ParameterLearner

LONG_GAP = 1.0
"""s: after a longer one the motion may be any."""


class CartFilter:
    """Learns while the cart is pushed: `update` takes a measurement and returns the estimate at its time.

    `arms` names those whose wrenches add up (None: all that are seen); `yaws` their contact frames' yaws. Below
    `least_speed` (m/s) of {b}'s origin nothing is learned, as in the paper's experiments. Wrenches are
    taken to be of the measurement's time: of those with a `time_delay`, hand over a log by `replay`.
    """

    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[str] | None = None,
        *,
        noise: FilterNoise | None = None,
        prior: Prior | None = None,
        yaws: Mapping[str, float] | None = None,
        least_speed: float = 0.0,
    ) -> None:
        self.cart, self.noise, self.prior = cart, noise or FilterNoise(), prior or Prior()
        self._learner = ParameterLearner(cart, arms, self.noise, self.prior, yaws or {}, least_speed)
        self._motion = DrivenMotion(cart, self.noise, self.prior.free(cart))
        self._started = False

    def update(self, measurement: Measurement) -> Estimate:
        """Predicts to the measurement's time, takes in what it holds, and says what is known."""
        learner, motion = self._learner, self._motion
        if not learner.take(measurement):
            return replace(self.estimate, health=Health.CLOCK)
        if self._started:
            if measurement.time - motion.time > LONG_GAP:
                motion.coast(measurement.time)
            motion.advance(measurement.time)
            motion.take(measurement.pose, measurement.velocity)
        else:
            pose = np.full(3, np.nan) if measurement.pose is None else np.asarray(measurement.pose, dtype=float)
            motion.start(measurement.time, pose)
            motion.take(None, measurement.velocity)
            self._started = math.isfinite(pose[2])  # without a heading nobody knows where anything pushes
        motion.learn(learner.theta, learner.covariance)
        if measurement.wrenches and learner.sensed is not None:
            motion.push(learner.sensed)
        return self.estimate

    @property
    def belief(self) -> Gaussian:
        """Mean and covariance of pose, nu and effect memory."""
        self._ask_begun()
        return self._motion.belief

    @property
    def nis(self) -> Mapping[str, tuple[float, int]]:
        """Normalised innovation squared of the last pose and velocity, with its dimension."""
        sizes = 3, self.cart.constraints.n_free
        found = zip(("pose", "velocity"), self._motion.nis.tolist(), sizes, strict=True)
        return {sensor: (value, size) for sensor, value, size in found if math.isfinite(value)}

    @property
    def estimate(self) -> Estimate:
        self._ask_begun()
        return self._learner.estimate(self._motion.motion)

    def _ask_begun(self) -> None:
        if not self._learner.has_begun:
            raise UsageError("filter: no measurement has come yet")
