"""Whether time stamps are in seconds: velocities over a time are a way, and poses tell how far it was.

Stamps in milliseconds make samples of seconds apart, from which nothing follows a motion. Where they are so far apart
that nothing is learned, ways by velocities are held against those of poses with each unit of time as a rival.
"""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.motion import Measurement

from ..sensor_check.evidence import probabilities
from ..sensor_check.suspicion import REFUSAL_PROBABILITY, Suspicion
from ..sensor_check.wrench_readings import UNIT_ODDS
from .competing_explanations import CompetingExplanations
from .first_motion import MAX_TRACKING_GAP
from .measured_motion import usable
from .regressor.parameter_learner import MAX_REGRESSION_GAP

TIME_UNITS = {"s": 1.0, "ms": 1e-3, "μs": 1e-6, "ns": 1e-9}
"""s."""
PATH_SAMPLES = 16
"""Samples of a way, so that it is longer than the noise of its ends."""


class ClockMonitor:
    """Takes samples in the order in which they come; those that are older than the newest pass unseen."""

    def __init__(self) -> None:
        self.is_apart = False
        """Whether the last sample came too long after the one before for a motion to be followed."""
        self._time = self._seen_at = -math.inf  # of the last sample, and of the last with a pose and a velocity
        self._gap = 0.0
        self._start_anew()

    def note(self, measurement: Measurement) -> None:
        gap, time = measurement.time - self._time, measurement.time
        if not gap > 0.0:
            return
        self.is_apart, self._time = MAX_TRACKING_GAP < gap < math.inf, time
        if measurement.pose is None or measurement.velocity is None:
            return
        self._gap, self._seen_at = time - self._seen_at, time
        if MAX_REGRESSION_GAP < self._gap < math.inf:
            self._go_on(usable(measurement.pose)[:2], usable(measurement.velocity)[:2], self._gap)
        elif self._rivals.rows or self._place is not None:
            self._start_anew()

    @property
    def suspicions(self) -> tuple[Suspicion, ...]:
        if not self._rivals.rows:
            return ()
        odds = np.array([1.0, *[UNIT_ODDS] * (len(TIME_UNITS) - 1)])
        _, *units = probabilities(np.array(self._rivals.evidence), odds).tolist()
        if not sum(units) > REFUSAL_PROBABILITY:
            return ()
        unit = list(TIME_UNITS)[1 + units.index(max(units))]
        words = (
            f"samples come every {self._gap:.3g} s by their stamps, and poses move as in {self._gap:.3g} {unit}: "
            f"times seem to be in {unit}, not s"
        )
        return (Suspicion("unit", "time", sum(units), TIME_UNITS[unit], words),)

    def _start_anew(self) -> None:
        self._rivals = CompetingExplanations((0.0,) * len(TIME_UNITS))
        self._place: Array | None = None
        self._velocity, self._way, self._samples = np.zeros(2), np.zeros(2), 0

    def _go_on(self, place: Array, velocity: Array, gap: float) -> None:
        """By one sample of the way, which is whole or begins a new one."""
        if not np.isfinite([place, velocity]).all():
            self._place = None
            return
        if self._place is None:
            self._place, self._way, self._samples = place, np.zeros(2), 0
        else:
            self._way, self._samples = self._way + 0.5 * gap * (self._velocity + velocity), self._samples + 1
        self._velocity = velocity
        if self._samples == PATH_SAMPLES:
            went = place - self._place
            left = [float(np.sum((went - unit * self._way) ** 2)) for unit in TIME_UNITS.values()]
            self._rivals, self._place = self._rivals.and_then(left, float(went @ went)), None
