"""What a log's sensors do, read off the log: signs, axes, units, frames, lags, scales, waves, and what recorders do."""

from .check import check_sensors
from .motion.velocity_clock import velocities_put_right
from .suspicion import KINDS, REFUSED, Suspicion

__all__ = ["KINDS", "REFUSED", "Suspicion", "check_sensors", "velocities_put_right"]
