"""What a log's sensors do that the log itself tells: lags, scales, signs, axes, units, and what recorders put in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cartgrasp.lazy_names import lazy_names

if TYPE_CHECKING:
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

_HOMES = {
    "check": "Sensors check_sensors put_right travelled",
    "sizes": "check_sizes",
    "suspicion": "KINDS REFUSED SURE Suspicion",
    "wrenches": "of_wrenches",
}

__getattr__, __dir__ = lazy_names(globals(), _HOMES)
