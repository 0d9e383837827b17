"""What a log's sensors do that the log itself tells: lags, scales, signs, axes, units, and what recorders put in."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cartgrasp.lazy_names import lazy_names

if TYPE_CHECKING:
    from .check import CorrectedLog, LogInspection, check_sensors, corrected_log, look_at
    from .fixed_wheels import wheel_suspicions
    from .sizes import check_sizes
    from .suspicion import REFUSAL_PROBABILITY, REFUSED_KINDS, SUSPICION_KINDS, Suspicion
    from .wrenches import wrench_suspicions

__all__ = [
    "REFUSAL_PROBABILITY",
    "REFUSED_KINDS",
    "SUSPICION_KINDS",
    "CorrectedLog",
    "LogInspection",
    "Suspicion",
    "check_sensors",
    "check_sizes",
    "corrected_log",
    "look_at",
    "wheel_suspicions",
    "wrench_suspicions",
]

_HOMES = {
    "check": "LogInspection CorrectedLog check_sensors look_at corrected_log",
    "fixed_wheels": "wheel_suspicions",
    "sizes": "check_sizes",
    "suspicion": "SUSPICION_KINDS REFUSED_KINDS REFUSAL_PROBABILITY Suspicion",
    "wrenches": "wrench_suspicions",
}

__getattr__, __dir__ = lazy_names(globals(), _HOMES)
