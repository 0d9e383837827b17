"""An open hand pushes and can't pull: fx >= 0. Friction implies it unless mu is 0."""

from __future__ import annotations

from cartgrasp.arms import Arm

from .limit import Limit, LimitRows

PUSH_ONLY = "push only"


class PushOnly(Limit):
    def rows(self, arm: Arm) -> LimitRows:
        plain = LimitRows()
        lower = plain.lower.copy()
        lower[0] = 0.0
        return LimitRows(lower=lower, lower_names=(PUSH_ONLY, *plain.lower_names[1:]))
