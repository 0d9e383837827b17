"""What a log's sensors do that the log itself tells: lags, scales, signs, axes, units, and what recorders put in."""

from .check import Sensors, check_sensors, put_right, travelled
from .sizes import check_sizes
from .suspicion import KINDS, REFUSED, SURE, Suspicion
from .wrenches import of_wrenches

__all__ = [
    "KINDS",
    "REFUSED",
    "SURE",
    "Sensors",
    "Suspicion",
    "check_sensors",
    "check_sizes",
    "of_wrenches",
    "put_right",
    "travelled",
]
