"""An open hand pushes and can't pull: fx >= 0. Friction implies it unless mu is 0."""

from __future__ import annotations

import numpy as np

from cartgrasp.arms import Arm

from .limit import Limit, LimitRows

PUSH_ONLY = "push only"
UNLIMITED_ROWS = LimitRows()
PUSH_ONLY_ROWS = LimitRows(
    lower=np.array([0.0, *UNLIMITED_ROWS.lower[1:]]),
    upper=UNLIMITED_ROWS.upper,
    lower_names=(PUSH_ONLY, *UNLIMITED_ROWS.lower_names[1:]),
)


class PushOnly(Limit):
    def rows(self, arm: Arm) -> LimitRows:
        return PUSH_ONLY_ROWS
