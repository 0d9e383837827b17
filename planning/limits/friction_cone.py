"""Coulomb friction itself: `‖(fy, fz)‖ <= mu fx`, push only."""

from __future__ import annotations

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from planning.quadratic_program import Cone

from .friction_pyramid import push_only
from .limit import Limit, LimitRows


class FrictionCone(Limit):
    def rows(self, arm: Arm) -> LimitRows:
        if arm.friction is None:
            raise UsageError(f"arm {arm.name}: a friction cone needs friction")
        matrix = np.zeros((3, 6))
        matrix[0, 0] = arm.friction.mu
        matrix[1, 1] = matrix[2, 2] = 1.0
        push = push_only()
        cone = Cone("friction cone", matrix, np.zeros(3))
        return LimitRows(lower=push.lower, lower_names=push.lower_names, cones=(cone,))
