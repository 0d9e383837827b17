"""Names of the ways to choose contacts."""

from __future__ import annotations

from typing import Literal, get_args

Strategy = Literal["fixed", "periodic", "least-effort", "teach", "schedule"]
STRATEGIES: tuple[Strategy, ...] = get_args(Strategy)
FIXED, PERIODIC, LEAST_EFFORT, TEACH, SCHEDULE = STRATEGIES
