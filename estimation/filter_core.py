"""What the online filter goes on with from sample to sample: learner, motion, and how each sensor does."""

from __future__ import annotations

import copy
import math
from typing import Self

import numpy as np

from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement

from .driven_motion import DrivenMotion
from .health import Health, SensorHealth
from .kernels.correction import GATE
from .regressor.parameter_learner import ParameterLearner

LONG_GAP = 1.0
"""s: after a longer one the motion may be any."""
SENSORS = ("pose", "velocity", "wrench")


class FilterCore:
    """Samples come in order."""

    def __init__(self, learner: ParameterLearner, motion: DrivenMotion) -> None:
        self.learner, self.motion = learner, motion
        self.sensors = dict.fromkeys(SENSORS, SensorHealth())
        self.time = -math.inf  # of the last sample
        self._gates, self._started = GATE * np.array(self.sizes, dtype=float), False

    @property
    def cart(self) -> CartModel:
        return self.learner.cart

    def take(self, measurement: Measurement) -> None:
        """Predicts to the measurement's time, and takes in what it holds."""
        learner, motion = self.learner, self.motion
        learner.take(measurement)
        self.time = learner.time
        if self._started:
            if measurement.time - motion.time > LONG_GAP:
                motion.coast(measurement.time)
            motion.advance(measurement.time, measurement.pose, measurement.velocity)
        else:
            pose = np.full(3, np.nan) if measurement.pose is None else np.asarray(measurement.pose, dtype=float)
            motion.start(measurement.time, pose)
            motion.advance(measurement.time, None, measurement.velocity)
            self._started = math.isfinite(pose[2])  # without a heading nobody knows where anything pushes
        motion.learn(learner.theta, learner.covariance)
        is_pushed = bool(measurement.wrenches) and learner.sensed is not None
        if is_pushed and learner.sensed is not None:
            motion.push(learner.sensed)
        self._note_sensors(measurement, is_pushed)

    @property
    def sizes(self) -> tuple[int, int]:
        """Of a pose, and of a velocity that is projected."""
        return 3, self.cart.constraints.n_free

    def estimate(self) -> Estimate:
        return self.learner.estimate(self.motion.motion, self.health)

    @property
    def health(self) -> Health:
        pose, velocity, wrench = self.sensors.values()
        if pose.is_missed:
            return Health.STALE
        if wrench.is_missed:
            return Health.NO_WRENCH
        learning = self.learner.health
        if learning is not Health.OK:
            return learning
        return Health.OUTLIERS if pose.has_outliers or velocity.has_outliers else Health.OK

    def copy(self) -> Self:
        other = copy.copy(self)
        other.learner, other.motion = self.learner.copy(), self.motion.copy()
        other.sensors = dict(self.sensors)
        return other

    def _note_sensors(self, measurement: Measurement, is_pushed: bool) -> None:
        time, sensors = measurement.time, self.sensors
        pose, velocity = (self.motion.now.nis / self._gates).tolist()
        if measurement.pose is not None and not math.isfinite(pose) and np.isfinite(measurement.pose).all():
            pose = 0.0  # where it began
        sensors["pose"] = sensors["pose"].seen(time, pose)
        sensors["velocity"] = sensors["velocity"].seen(time, velocity)
        wrench = self.learner.surprise if is_pushed else math.nan
        sensors["wrench"] = sensors["wrench"].seen(time, wrench)
