"""What a log's sensors do that the log itself tells: lags, scales, signs, axes, units, and what recorders put in."""

from .check import Look, Sensors, check_sensors, look_at, put_right
from .sizes import check_sizes
from .suspicion import KINDS, REFUSED, SURE, Suspicion
from .wrenches import of_wrenches

__all__ = [
    "KINDS",
    "REFUSED",
    "SURE",
    "Look",
    "Sensors",
    "Suspicion",
    "check_sensors",
    "check_sizes",
    "look_at",
    "of_wrenches",
    "put_right",
]
