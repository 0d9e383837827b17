"""Fixed wheels that creep sideways under side load, as tyres do: at a slip angle in proportion to the force.

    w_axle = |v| F / cornering_stiffness,    F = -lambda,

with v the wheels' rolling speed and lambda the force by which the floor holds them (physics.md). The creep moves the
pose (`creep.py`); accelerations are those of wheels that hold, as it is slow and changes slowly. At rest nothing
creeps. Simulated sensors of velocity leave it out; estimators take it for noise of the path, as they don't carry the
side force of the hands.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self, final

from .effect import ConstraintEffect, Parameter

RIGID_STIFFNESS = 1e9
"""N/rad: from here on nothing creeps."""
TYPICAL_STIFFNESS = 1000.0
"""N/rad."""


@final
@dataclass(frozen=True)
class LateralSlip(ConstraintEffect):
    """All fixed wheels together have `cornering_stiffness` (N/rad)."""

    cornering_stiffness: float = RIGID_STIFFNESS

    name = "lateral_slip"
    parameters = (
        Parameter(
            "cornering_stiffness", "N/rad", typical=RIGID_STIFFNESS, lower=10.0, absent=RIGID_STIFFNESS, estimated=False
        ),
    )
    signature = "a velocity across the wheels in proportion to speed times side force"

    @classmethod
    def usual(cls, label: str) -> Self:
        return cls(TYPICAL_STIFFNESS, label=label)

    def scaled(self, share: float) -> Self:
        return self.with_values([self.cornering_stiffness / max(share, self.cornering_stiffness / RIGID_STIFFNESS)])

    @property
    def slip_compliance(self) -> float:
        return 1.0 / self.cornering_stiffness if self.cornering_stiffness < RIGID_STIFFNESS else 0.0
