"""A tracker that follows another point of the cart than {b}'s origin, or in another direction.

With {t} the frame that is tracked, the recorded pose is `pose_st = pose_sb pose_tb⁻¹`, and the recorded velocity that
of {t}'s origin. Wrenches are recorded as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from ..frames import Array
from .effect import LeavesWrenches, Parameter


@final
@dataclass(frozen=True)
class PoseOffset(LeavesWrenches):
    """{b} is at (`x`, `y`) (m) in the tracked frame, turned by `yaw` (rad): `x` is negative where the tracked point is
    ahead of {b}'s origin."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    name = "pose_offset"
    parameters = (
        Parameter("x", "m", typical=0.03),
        Parameter("y", "m", typical=0.03),
        Parameter("yaw", "rad", typical=0.03, lower=-np.pi, upper=np.pi),
    )
    by_arm = False
    signature = "a velocity across the wheels in proportion to the yaw rate, or to the speed"
    moves_pose = True

    def pose_tb(self, parameters: Array) -> Array:
        return parameters
