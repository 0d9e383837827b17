"""What a log's sensors do that the log itself tells: lags, scales, signs, axes, units, and what recorders put in."""

from .check import Sensors, check_sensors, put_right, travelled
from .suspicion import KINDS, REFUSED, SURE, Suspicion
from .wrenches import of_wrenches

__all__ = [
    "KINDS",
    "REFUSED",
    "SURE",
    "Sensors",
    "Suspicion",
    "check_sensors",
    "of_wrenches",
    "put_right",
    "travelled",
]
