"""Names of the ways to choose contacts."""

from __future__ import annotations

from typing import Literal, get_args

Way = Literal["fixed", "periodic", "least-effort", "teach", "schedule"]
WAYS: tuple[Way, ...] = get_args(Way)
FIXED, PERIODIC, LEAST_EFFORT, TEACH, SCHEDULE = WAYS
