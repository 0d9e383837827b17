"""Coulomb friction, push only (fx >= 0): `‖(fy, fz)‖ <= mu fx`, as this cone and as a pyramid inscribed in it.

The pyramid's edges (generators) are `fx (1, mu cos a_k, mu sin a_k)` with a_k = 2 pi k / sides from y. Row
"friction edge k" is the side from edge k to edge k + 1, with normal at a_k + pi / sides:

    cos(a_k + pi/sides) fy + sin(a_k + pi/sides) fz <= mu cos(pi/sides) fx.

A force on edge k makes rows k - 1 and k active.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from planning.quadratic_program import Cone

from .bounds import PUSH_ONLY_ROWS
from .limit import Limit, LimitRows


class FrictionCone(Limit):
    def rows(self, arm: Arm) -> LimitRows:
        if arm.friction is None:
            raise UsageError(f"arm {arm.name}: a friction cone needs friction")
        matrix = np.zeros((3, 6))
        matrix[0, 0] = arm.friction.mu
        matrix[1, 1] = matrix[2, 2] = 1.0
        cone = Cone("friction cone", matrix, np.zeros(3))
        return LimitRows(lower=PUSH_ONLY_ROWS.lower, lower_names=PUSH_ONLY_ROWS.lower_names, cones=(cone,))


class FrictionPyramid(Limit):
    def rows(self, arm: Arm) -> LimitRows:
        if arm.friction is None or not isinstance(arm.friction.sides, int):
            raise UsageError(f"arm {arm.name}: a friction pyramid needs friction with a number of sides")
        push = PUSH_ONLY_ROWS
        rows, limits, names = _sides(arm.friction.mu, arm.friction.sides)
        return LimitRows(push.lower, push.upper, push.lower_names, push.upper_names, rows, limits, names)


@lru_cache(maxsize=64)
def _sides(mu: float, sides: int) -> tuple[Array, Array, tuple[str, ...]]:
    angles = (2 * np.arange(sides) + 1) * np.pi / sides
    rows = np.zeros((sides, 6))
    rows[:, 0] = -mu * np.cos(np.pi / sides)
    rows[:, 1], rows[:, 2] = np.cos(angles), np.sin(angles)
    limits = np.zeros(sides)
    rows.setflags(write=False)
    limits.setflags(write=False)
    return rows, limits, tuple(f"friction edge {k}" for k in range(sides))
