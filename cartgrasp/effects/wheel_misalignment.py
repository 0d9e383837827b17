"""Fixed wheels whose axis is not square to the cart: it rolls at an angle to {b}'s x.

With the axle at x = a the wheels forbid `(-sin, cos) · (u, w + a r) = 0` at their angle, so the free velocities are
the speed along the wheels' rolling and r. Fixed wheels that drag still do so along {b}'s x: in the reduced wrench that
is off by `1 - cos(angle)`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self, final

from ..constraints import RollingConstraints
from .effect import ConstraintEffect, Parameter


@final
@dataclass(frozen=True)
class WheelMisalignment(ConstraintEffect):
    """The fixed wheels roll at `angle` (rad) to {b}'s x, to its left where positive."""

    angle: float = 0.0

    name = "wheel_misalignment"
    parameters = (Parameter("angle", "rad", typical=0.02, lower=-0.5, upper=0.5, estimated=False),)
    signature = "a velocity across the cart in proportion to its forward speed"

    @classmethod
    def usual(cls, label: str) -> Self:
        return cls(cls.parameters[0].typical, label=label)

    def scaled(self, share: float) -> Self:
        return self.with_values([share * self.angle])

    def rolling(self, constraints: RollingConstraints) -> RollingConstraints:
        return replace(constraints, angle=constraints.angle + self.angle)
