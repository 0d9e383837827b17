"""The filter: a regression learns the parameters, and the recorded wrench drives the motion.

An augmented EKF (8)-(20) takes noise of the wrench that drives it for motion that it did not make, and learns a mass
that is too large, too surely (errors in variables, physics.md). So the two are kept apart. Parameters are learned by
`ParameterLearner`, whose rows have the wrench's noise on one side; motion is a Kalman filter that the recorded wrench
drives, with what is not known of wrench and parameters in its covariance, and no gain of its own on the latter
(Schmidt 1966). Where a new estimate of the parameters takes the motion, its slopes by them tell.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Self

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement
from cartgrasp.shallow_copy import shallow_copy

from ..gaussian import Gaussian
from ..health import SensorHealth, by_sensor, overall_health
from .first_motion import MAX_TRACKING_GAP
from .kernels.sensor_health import OUTLYING
from .measured_motion import NO_MOTION, NO_WRENCHES, MeasuredMotion
from .regressor.parameter_learner import ParameterLearner
from .regressor.wrench_noise_scale import WrenchNoiseScale
from .schmidt_filter import SchmidtFilter


class LearningFilter:
    """The learner and the motion of one cart. Samples come in the order of their times; `LateSamples` sees to that."""

    def __init__(self, learner: ParameterLearner, motion: SchmidtFilter) -> None:
        self.learner, self.motion = learner, motion
        self.time = -math.inf  # of the last sample
        self._started = False

    @property
    def cart(self) -> CartModel:
        return self.learner.cart

    @property
    def took_long(self) -> bool:
        """Whether the last sample took longer than most."""
        return self.learner.took_long

    @property
    def wrench_noise_scale(self) -> WrenchNoiseScale:
        return self.learner.wrench_noise_scale

    def take(self, measurement: Measurement) -> None:
        """Predicts to the measurement's time, and takes in what it holds."""
        learner, motion = self.learner, self.motion
        learner.take(measurement)
        self.time = learner.time
        self._move(float(measurement.time), learner.seen, learner.measured_wrench)
        if learner.is_torn and not motion.said & OUTLYING:
            learner.begin_anew()
        motion.believe(learner.learned.theta, learner.learned.covariance)

    def _move(self, time: float, seen: Array, felt: Array = NO_WRENCHES) -> None:
        """Takes the motion to a time, with what is `seen` (6,) then, and `felt` as in `SchmidtFilter.advance`."""
        motion = self.motion
        if not self._started:
            motion.start(time, seen[:3])
            self._started = math.isfinite(seen[2])  # without a heading nobody knows where anything pushes
            seen = np.concatenate([NO_MOTION[:3], seen[3:]])
        elif time - motion.time > MAX_TRACKING_GAP:
            motion.coast(time)
        motion.advance(time, seen, felt, self.learner.learned.gate_ratio)

    def scale_noise(self, noise_factors: Array) -> None:
        """Variances of velocities, linear and yaw (2,), are so many times the declared ones."""
        self.learner.scale_noise(noise_factors)
        self.motion.scale_noise(noise_factors)

    def predicted_through(self, samples: Sequence[Measurement]) -> Self:
        """A copy that has seen later motion, and learned nothing."""
        other, seen = shallow_copy(self), MeasuredMotion()
        other.motion = self.motion.copy()
        for sample in samples:
            other._move(sample.time, seen.of(sample))
        return other

    @property
    def sizes(self) -> tuple[int, int]:
        """The dimensions of a pose, and of a velocity that is projected onto nu."""
        return 3, self.cart.constraints.n_free

    def estimate(self) -> Estimate:
        learner, motion = self.learner, self.motion
        return learner.estimate(motion.motion, overall_health(motion.said, learner.health))

    @property
    def sensors(self) -> Mapping[str, SensorHealth]:
        """How pose, velocity and wrench do."""
        return by_sensor(self.motion.now.health)

    @property
    def belief(self) -> Gaussian:
        """Mean and covariance of pose, nu and effect memory."""
        return self.motion.belief

    @property
    def nis(self) -> Mapping[str, tuple[float, int]]:
        """Normalised innovation squared of the last measurement's pose and velocity, with its dimension."""
        found = zip(("pose", "velocity"), self.motion.now.nis.tolist(), self.sizes, strict=True)
        return {sensor: (value, size) for sensor, value, size in found if math.isfinite(value)}

    def copy(self) -> Self:
        other = shallow_copy(self)
        other.learner, other.motion = self.learner.copy(), self.motion.copy()
        return other
