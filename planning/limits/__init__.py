"""Limits of what an arm can give at a contact, one small file each."""

from __future__ import annotations

from cartgrasp.arms import EXACT, Arm

from .friction_cone import FrictionCone
from .friction_pyramid import FrictionPyramid
from .limit import Limit, LimitRows
from .wrench_box import WrenchBox

__all__ = ["FrictionCone", "FrictionPyramid", "Limit", "LimitRows", "WrenchBox", "limits_of"]


def limits_of(arm: Arm) -> LimitRows:
    """All that an arm states about itself, as one set of rows."""
    rows = WrenchBox().rows(arm)
    if arm.friction is None:
        return rows
    friction: Limit = FrictionCone() if arm.friction.sides == EXACT else FrictionPyramid()
    return rows & friction.rows(arm)
