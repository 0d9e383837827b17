"""Soft fingers: ‖(f, m / twist_radius)‖ <= mu N, with f the force along the pads and m the moment about their normal.

N is the push along the normal of an open hand, which only pushes, or twice the grip of two fingers. The polytope has
its corners on the ellipsoid: `sides` on each of several rings of latitude, at angles 2 pi k / sides from the first axis
along the pad, and the poles. With no moment it is the friction pyramid. A side between the rings at latitudes p and q
and between two corners has, with c = cos(pi / sides),

    (sin q - sin p) f · n + (cos p - cos q) c m / twist_radius <= c sin(q - p) mu N,    n in the middle of the corners.
"""

from __future__ import annotations

from functools import lru_cache
from math import cos, pi, sin

import numpy as np

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.friction import EXACT, NORMALS
from planning.quadratic_program import Cone

from .bounds import PUSH_ONLY
from .limit import Limit, LimitRows


class SoftFingerLimit(Limit):
    def rows(self, arm: Arm) -> LimitRows:
        finger = arm.soft_finger
        if finger is None:
            raise UsageError(f"arm {arm.name}: a limit of soft fingers needs soft_finger")
        normal, plain = NORMALS.index(finger.normal), LimitRows()
        lower, lower_names = plain.lower, plain.lower_names
        pressed, twice_grip = np.zeros(6), 2.0 * finger.mu * finger.grip
        if not finger.grip:
            pressed[normal], lower = finger.mu, lower.copy()
            lower[normal] = 0.0
            lower_names = (*lower_names[:normal], PUSH_ONLY, *lower_names[normal + 1 :])
        borne = np.delete(np.eye(6)[:4], normal, axis=0)
        borne[2] = np.eye(6)[3 + normal] / finger.twist_radius
        if finger.sides == EXACT:
            cone = Cone("soft finger", np.vstack([pressed, borne]), np.array([twice_grip, 0.0, 0.0, 0.0]))
            return LimitRows(lower=lower, lower_names=lower_names, cones=(cone,))
        normals, distances, names = polytope(int(finger.sides))
        rows = normals @ borne - distances[:, None] * pressed
        return LimitRows(lower, plain.upper, lower_names, plain.upper_names, rows, distances * twice_grip, names)


@lru_cache(maxsize=64)
def polytope(sides: int) -> tuple[Array, Array, tuple[str, ...]]:
    """Unit normals (k, 3) of the polytope in the unit ball, its sides' distances (k,) from the middle, and names."""
    rings, inner = max(1, round(sides / 4)), cos(pi / sides)
    normals, distances = [], []
    for ring in range(-rings, rings):
        low, high = pi * ring / (2 * rings), pi * (ring + 1) / (2 * rings)
        out, up = sin(high) - sin(low), inner * (cos(low) - cos(high))
        length = float(np.hypot(out, up))
        for k in range(sides):
            angle = (2 * k + 1) * pi / sides
            normals.append([out * cos(angle) / length, out * sin(angle) / length, up / length])
            distances.append(inner * sin(high - low) / length)
    found = np.array(normals), np.array(distances)
    for part in found:
        part.setflags(write=False)
    return *found, tuple(f"soft finger side {k}" for k in range(len(distances)))
