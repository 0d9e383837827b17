"""What a log's sensors do that the log itself tells: lags, scales, signs, axes, units, and what recorders put in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cartgrasp.lazy_names import lazy_names

if TYPE_CHECKING:
    from .check import Look, Sensors, check_sensors, look_at, put_right
    from .fixed_wheels import of_wheels
    from .sizes import check_sizes
    from .suspicion import REFUSAL_PROBABILITY, REFUSED_KINDS, SUSPICION_KINDS, Suspicion
    from .wrenches import of_wrenches

__all__ = [
    "REFUSAL_PROBABILITY",
    "REFUSED_KINDS",
    "SUSPICION_KINDS",
    "Look",
    "Sensors",
    "Suspicion",
    "check_sensors",
    "check_sizes",
    "look_at",
    "of_wheels",
    "of_wrenches",
    "put_right",
]

_HOMES = {
    "check": "Look Sensors check_sensors look_at put_right",
    "fixed_wheels": "of_wheels",
    "sizes": "check_sizes",
    "suspicion": "SUSPICION_KINDS REFUSED_KINDS REFUSAL_PROBABILITY Suspicion",
    "wrenches": "of_wrenches",
}

__getattr__, __dir__ = lazy_names(globals(), _HOMES)
