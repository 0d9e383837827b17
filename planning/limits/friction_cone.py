"""Coulomb friction itself: `‖(fy, fz)‖ <= mu fx`, push only."""

from __future__ import annotations

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from planning.quadratic_program import Cone

from .limit import Limit, LimitRows
from .push_only import PushOnly


class FrictionCone(Limit):
    def rows(self, arm: Arm) -> LimitRows:
        if arm.friction is None:
            raise UsageError(f"arm {arm.name}: a friction cone needs friction")
        matrix = np.zeros((3, 6))
        matrix[0, 0] = arm.friction.mu
        matrix[1, 1] = matrix[2, 2] = 1.0
        push = PushOnly().rows(arm)
        cone = Cone("friction cone", matrix, np.zeros(3))
        return LimitRows(lower=push.lower, lower_names=push.lower_names, cones=(cone,))
