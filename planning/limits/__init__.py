"""Limits: of an arm at its contact (`Limit`), and of the hands together (`CartLimit`)."""

from __future__ import annotations

import math

from cartgrasp.arms import Arm
from cartgrasp.friction import EXACT

from .bounds import JointTorque, Payload, PushOnly, WrenchBox
from .cart_limit import CartLimit, CartRows, PushedCart, cart_rows
from .floor_limit import FloorLimit, FloorRows
from .friction import FrictionCone, FrictionPyramid
from .internal_force import InternalForce
from .limit import Limit, LimitRows, joined, user_rows
from .pull import Pull
from .soft_finger import SoftFingerLimit
from .wheel_limits import SideForce, Skid, TipOver
from .wrench_rate import WrenchRate

__all__ = [
    "CartLimit",
    "CartRows",
    "FloorLimit",
    "FloorRows",
    "FrictionCone",
    "FrictionPyramid",
    "InternalForce",
    "JointTorque",
    "Limit",
    "LimitRows",
    "Payload",
    "Pull",
    "PushOnly",
    "PushedCart",
    "SideForce",
    "Skid",
    "SoftFingerLimit",
    "TipOver",
    "WrenchBox",
    "WrenchRate",
    "cart_rows",
    "joined",
    "limits_of",
]


def limits_of(arm: Arm) -> LimitRows:
    """All that an arm states about itself, as one set of rows; its rate is about the last wrench, see `WrenchRate`."""
    return LimitRows.all_of(
        [*(limit.rows(arm) for limit in _stated(arm)), *(user_rows(limit, arm) for limit in arm.limits)]
    )


def _stated(arm: Arm) -> list[Limit]:
    stated: list[Limit] = [WrenchBox()]
    if arm.friction is not None:
        stated.append(FrictionCone() if arm.friction.sides == EXACT else FrictionPyramid())
    if arm.soft_finger is not None:
        stated.append(SoftFingerLimit())
    if arm.push_only:
        stated.append(PushOnly())
    if math.isfinite(arm.payload):
        stated.append(Payload())
    if arm.joints is not None:
        stated.append(JointTorque())
    return stated
