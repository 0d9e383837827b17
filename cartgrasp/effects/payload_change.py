"""Mass put on, or taken off, at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from .compiled import CompiledInertia
from .effect import Gate, Parameter

PAYLOAD_POSITION_GRID = (-0.3, 0.0, 0.3)


@final
@dataclass(frozen=True)
class PayloadChange(CompiledInertia):
    """A point mass `mass` (kg, negative: taken off) at (x, y) in {b} (m) from `time` (s) on.

    The mass joins at the cart's velocity, so velocities do not jump.
    """

    time: float = 0.0
    mass: float = 0.0
    x: float = 0.0
    y: float = 0.0

    name = "payload_change"
    parameters = (
        Parameter("time", "s", typical=10.0, estimated=False),
        Parameter("mass", "kg", typical=5.0),
        Parameter("x", "m", typical=0.2, grid=PAYLOAD_POSITION_GRID),
        Parameter("y", "m", typical=0.2, grid=PAYLOAD_POSITION_GRID),
    )
    gate = Gate.FROM
    signature = "mass and CoM differ before and after an instant"
