"""What an estimator says of itself, and how often it may take a load for changed."""

from __future__ import annotations

from enum import StrEnum

HOLD_OFF = 1.5
"""s after a reset in which a load is called changed, and nothing is reset again."""
MOST_RESETS, MEMORY = 3, 20.0


class Health(StrEnum):
    """One word a controller can read."""

    OK = "ok"
    NO_WRENCH = "no_wrench"
    OUTLIERS = "outliers"
    LOAD_CHANGED = "load_changed"
    INCONSISTENT = "inconsistent"
    CLOCK = "clock_went_back"
