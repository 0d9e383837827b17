"""An arm rated for a payload gives at most its weight up or down: |fz| <= payload · 9.81 m/s²."""

from __future__ import annotations

from cartgrasp.arms import Arm
from cartgrasp.wheels import GRAVITY

from .limit import Limit, LimitRows


class Payload(Limit):
    def rows(self, arm: Arm) -> LimitRows:
        plain, weight = LimitRows(), GRAVITY * arm.payload
        lower, upper = plain.lower.copy(), plain.upper.copy()
        lower[2], upper[2] = -weight, weight
        return LimitRows(lower, upper, _named("payload lower"), _named("payload upper"))


def _named(name: str) -> tuple[str, ...]:
    return ("", "", name, "", "", "")
