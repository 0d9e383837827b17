"""A symmetric box: |F| <= limit per axis of {a}, N and N·m."""

from __future__ import annotations

from cartgrasp.arms import Arm

from .limit import Limit, LimitRows


class WrenchBox(Limit):
    def rows(self, arm: Arm) -> LimitRows:
        return LimitRows(lower=-arm.wrench_limit, upper=arm.wrench_limit)
