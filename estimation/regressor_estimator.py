"""The filtered-regressor estimator: parameters from a regression on motion, motion from poses alone."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from cartgrasp.checks import brief
from cartgrasp.errors import UsageError
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement
from cartgrasp.tracked_point import TrackedPoint

from .gaussian import Gaussian
from .given import check_measurement, given
from .health import Health
from .late_samples import LateSamples
from .noise import FilterNoise
from .prior import Prior
from .regressor.parameter_learner import ParameterLearner
from .sensor_watch import SensorWatch


class RegressorEstimator:
    """Learns while the cart is pushed, as `CartFilter` does and with its arguments, and what it learns."""

    aligns: ClassVar[bool] = False

    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[str] | None = None,
        *,
        noise: FilterNoise | None = None,
        prior: Prior | None = None,
        yaws: Mapping[str, float] | None = None,
    ) -> None:
        made_of = given(cart, arms, noise, prior, yaws)
        self.cart, _, self.noise, self.prior, _ = made_of
        self._tracked = TrackedPoint(cart.pose_tb)
        with np.errstate(all="ignore"):  # what is told of the noise may be beyond reason
            self._samples = LateSamples(ParameterLearner(*made_of))
        self._watch = SensorWatch(*made_of)

    def update(self, measurement: Measurement) -> Estimate:
        """Goes on to the measurement's time, takes in what it holds, and says what is known."""
        try:
            is_taken = self._samples.take(self._tracked.at_body(measurement))
            now = measurement.time + self._samples.ahead
            if now >= self._watch.due and not self._learner.worked and self._watch.go_on(now, self._samples.last):
                self._learner.hear(self._watch.loudness)
        except (TypeError, ValueError, AttributeError):
            check_measurement(measurement)
            raise
        found = self.estimate
        return found if is_taken else found._replace(health=Health.CLOCK)

    def __repr__(self) -> str:
        seen = "no measurement yet" if self._learner.time == -math.inf else repr(self.estimate)
        return brief("RegressorEstimator", self.cart.name, seen)

    @property
    def belief(self) -> Gaussian:
        """Mean and covariance of the free parameters, physical or not."""
        return self._learner.belief

    @property
    def lateness(self) -> float:
        """Of the wrenches, beyond being held from sample to sample, in sample periods; mere samples have -0.5."""
        return self._learner.lateness

    @property
    def estimate(self) -> Estimate:
        learner = self._learner
        if learner.time == -math.inf:
            raise UsageError("regressor: no measurement has come yet")
        found, ahead = learner.estimate(learner.motion, learner.health), self._samples.ahead
        if self._watch.suspicions:
            found = self._watch.qualified(found)
        return found._replace(time=found.time - ahead) if ahead else found

    @property
    def _learner(self) -> ParameterLearner:
        return self._samples.state
