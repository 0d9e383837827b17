"""Stribeck friction: a peak of drag near standstill that fades as the wheels get going.

    f(v) = -breakaway * v / |v| * exp(-(|v| / speed)²)

A share `by_wheels` of it acts at the wheels, each against its own rolling in proportion to its load; the rest at {b}'s
origin, with v = (u, w). Straight ahead both are alike; in a turn on the spot only wheels drag. The sign is smoothed
like that of every Coulomb force (`effect.py`), so exactly at rest the force is 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from .compiled import WheelForce
from .effect import Parameter

STRIBECK_SPEED_GRID = (0.03, 0.06, 0.12, 0.25)


@final
@dataclass(frozen=True)
class StribeckFriction(WheelForce):
    """Drag of at most `breakaway` (N), gone at some times `speed` (m/s)."""

    breakaway: float = 0.0
    speed: float = 0.05
    by_wheels: float = 0.0

    name = "stribeck_friction"
    parameters = (
        Parameter("breakaway", "N", typical=5.0, lower=0.0),
        Parameter(
            "speed",
            "m/s",
            typical=0.05,
            lower=0.001,
            upper=10.0,
            absent=0.05,
            estimated=False,
            grid=STRIBECK_SPEED_GRID,
        ),
        Parameter("by_wheels", "-", typical=0.5, lower=0.0, upper=1.0, estimated=False, grid=(0.0, 1.0)),
    )
    signature = "a peak of the forward force near standstill, gone at speed"
