"""An open hand pushes and can't pull: fx >= 0. Friction implies it unless mu is 0."""

from __future__ import annotations

import numpy as np

from cartgrasp.arms import Arm

from .limit import Limit, LimitRows

PUSH_ONLY = "push only"
NONE = LimitRows()
ROWS = LimitRows(
    lower=np.array([0.0, *NONE.lower[1:]]), upper=NONE.upper, lower_names=(PUSH_ONLY, *NONE.lower_names[1:])
)


class PushOnly(Limit):
    def rows(self, arm: Arm) -> LimitRows:
        return ROWS
