"""The motion between what poses and velocities tell: from the last of them the cart goes on under the wrenches.

White jerk, which the regression follows the motion with, goes on with the last acceleration, whatever is given since.
Whoever feeds such a motion back pushes ever harder against what is not there.
"""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.motion import Measurement, Motion
from cartgrasp.simulation.integrate import held

from .parameter_learner import ParameterLearner

MAX_RECKONING_STEP = 0.01
"""s."""


class ReckoningLearner(ParameterLearner):
    """Its `told_motion` hears of the wrenches where nothing is seen of the motion."""

    _state: Array | None = None  # (n,), of the cart at the time of the last sample, where nothing was seen then

    def take(self, measurement: Measurement) -> None:
        before, last = self.time, (self.motion, self._felt()) if self._started else None
        super().take(measurement)
        if self.is_torn:  # nobody else says where the cart is
            self.begin_anew()
        if last is None or self._motion_seen_at == self.time:
            self._state = None
            return
        motion, felt = last
        if self._state is None:
            self._state = self.cart.state(*motion[:2])
        if (elapsed := self.time - before) > 0.0:
            steps = max(1, math.ceil(elapsed / MAX_RECKONING_STEP))
            cart, wrench = self.estimate(self.motion, self.health).cart(), self.cart.planar_wrench(felt)
            self._state = held(cart, self._state, wrench, before, (elapsed / steps, steps))

    @property
    def told_motion(self) -> Motion:
        """As seen, or as it goes on since."""
        if self._state is None:
            return self.motion
        return Motion(self._state[:3].copy(), self._state[self.cart.velocity_slice].copy())

    def _felt(self) -> Array:
        """The reduced wrench (f,) of the arms that goes on from the last sample; 0 where nobody tells one."""
        row, f = self.tracker.measured_wrench, self.cart.constraints.n_free
        return np.array(row[1 : 1 + f]) if math.isfinite(row[0]) else np.zeros(f)
