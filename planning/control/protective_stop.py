"""The protective stop: a cart that is far off its path, or whose motion is surely not what is measured of it, is not
driven there but stopped.

A pose source that changes its origin, or turns by half a turn, moves the cart where it is not; with a heading that is
wrong, what brakes by the measured velocity drives. So a stop is monitored, as in the stop category SS1 of IEC
61800-5-2: kinetic energy that grows while it should fade ends it, and nothing is given any more (STO).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Reference
from cartgrasp.rigid_body import mass_matrix_b

from ..steering import Triple, error_b

MAX_ENERGY_RATIO, MAX_ENERGY_SPEED = 1.5, 0.2
"""Times the kinetic energy with which a stop began, beside that of this speed (m/s): braking leaves less."""
MIN_JUMP = 0.3
"""m or rad between two ticks, which no cart moves: the pose is believed to be elsewhere, and the stop begins anew."""
MOTION_SOURCES = frozenset({"pose", "heading", "velocity", "yaw_rate"})
"""Where a `Suspicion` is of the motion's sensors."""


class Stage(Enum):
    DRIVES = "drives"
    BRAKES = "brakes"
    LETS_GO = "lets go"


@dataclass(frozen=True)
class ProtectiveStop:
    """What is done, why, the kinetic energy (J) with which the stop began, and the error as `error_b` has it."""

    stage: Stage = Stage.DRIVES
    why: str = ""
    energy: float = math.inf
    error: Triple = (math.inf, math.inf, math.inf)

    def after(self, cart: CartModel, there: Reference, estimate: Estimate, most: float) -> ProtectiveStop:
        """A tick later, of a `cart` that is to be `there`, `most` m and rad from it at most."""
        error = error_b(there.pose_sb, estimate.motion.pose_sb, cart.rolling.axle_x or 0.0)
        misled = _why_misled(estimate)
        why = misled or _why_astray(error, most)
        if not why:
            return DRIVING
        twist_b, matrix = cart.basis_b @ estimate.motion.velocity, mass_matrix_b(cart.inertia.phi)
        energy = 0.5 * float(twist_b @ matrix @ twist_b)
        begins = max(abs(new - old) for new, old in zip(error, self.error, strict=True)) > MIN_JUMP
        begun = energy if begins else self.energy
        grows = energy > MAX_ENERGY_RATIO * begun + 0.5 * float(matrix[0, 0]) * MAX_ENERGY_SPEED**2
        if misled or grows or (self.stage is Stage.LETS_GO and not begins):
            return ProtectiveStop(Stage.LETS_GO, f"gives nothing: {why}", begun, error)
        return ProtectiveStop(Stage.BRAKES, f"stops: {why}", begun, error)


DRIVING = ProtectiveStop()


def _why_astray(error: Triple, most: float) -> str:
    """In words, that the cart is more than so many m, or rad, off its path; empty where it is not."""
    x, y, heading = error
    off = math.hypot(x, y)
    if off > most:
        return f"the cart is {off:.2g} m off its path"
    return f"the cart heads {abs(math.degrees(heading)):.0f}° off its path" if abs(heading) > most else ""


def _why_misled(estimate: Estimate) -> str:
    """In words, how what is measured of the motion surely isn't it; empty where nothing is known of that."""
    for one in estimate.suspicions:
        if one.where in MOTION_SOURCES and getattr(one, "is_refused", False):
            return str(one.words)
    return ""
