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

from cartgrasp.errors import UsageError
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement

from .driven_motion import DrivenMotion
from .filter_core import FilterCore
from .gaussian import Gaussian
from .health import Health, SensorHealth
from .late_samples import LateSamples
from .noise import FilterNoise
from .prior import Prior
from .regressor.parameter_learner import ParameterLearner


class CartFilter:
    """Learns while the cart is pushed: `update` takes a measurement and returns the estimate at its time.

    Sensors may have rates of their own, with a measurement for each of their samples, which may be up to 0.3 s late.
    `arms` names those whose wrenches add up (None: all that are seen); `yaws` their contact frames' yaws. Wrenches are
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
    ) -> None:
        self.cart, self.noise, self.prior = cart, noise or FilterNoise(), prior or Prior()
        learner = ParameterLearner(cart, arms, self.noise, self.prior, yaws or {})
        core = FilterCore(learner, DrivenMotion(cart, self.noise, self.prior.free(cart)))
        self._samples = LateSamples(core)

    def update(self, measurement: Measurement) -> Estimate:
        """Predicts to the measurement's time, takes in what it holds, and says what is known. Of a late one, what is
        known at the time of the newest; one that is too late is left out (`clock_went_back`)."""
        if not math.isfinite(measurement.time):
            raise UsageError(f"measurement: time {measurement.time} is not finite")
        if not self._samples.take(measurement):
            return replace(self.estimate, health=Health.CLOCK)
        return self.estimate

    @property
    def belief(self) -> Gaussian:
        """Mean and covariance of pose, nu and effect memory."""
        return self._core.motion.belief

    @property
    def nis(self) -> Mapping[str, tuple[float, int]]:
        """Normalised innovation squared of the last measurement's pose and velocity, with its dimension."""
        core = self._core
        found = zip(("pose", "velocity"), core.motion.now.nis.tolist(), core.sizes, strict=True)
        return {sensor: (value, size) for sensor, value, size in found if math.isfinite(value)}

    @property
    def sensors(self) -> Mapping[str, SensorHealth]:
        """How pose, velocity and wrench do."""
        return dict(self._core.sensors)

    @property
    def estimate(self) -> Estimate:
        found, ahead = self._core.estimate(), self._samples.ahead
        return replace(found, time=found.time - ahead) if ahead else found

    @property
    def _core(self) -> FilterCore:
        if self._samples.state.time == -math.inf:
            raise UsageError("filter: no measurement has come yet")
        return self._samples.state
