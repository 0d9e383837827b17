"""The protective stop: a cart that is far off its path, or whose motion is surely not what is measured of it, is not
driven there but stopped.

A pose source that changes its origin, or turns by half a turn, moves the cart where it is not; with a heading that is
wrong, what brakes by the measured velocity drives. So a stop is monitored, as in the stop category SS1 of IEC
61800-5-2: while the cart is quick its kinetic energy has to fall, else nothing is given (STO). That may be for a push,
too. So after a pause, which is twice as long each time, it is braked again, and gently.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Motion, Reference
from cartgrasp.rigid_body import mass_matrix_b

from ..steering import Triple, error_b
from ..tracking import wrench_as_it_moves

BRAKING_TIME_CONSTANT = 0.5
"""s: the time constant; after four of these, 2 s, 2 % of the velocity is left."""
MONITORING_INTERVAL, MONITORED_SPEED = 0.2, 0.5
"""s in which braking has to have taken energy; and m/s of a cart that is quick enough for a slope not to do more."""
HOLDING_SPEED, MAX_HOLD = 0.3, 0.3
"""m/s, below which a cart is held where it is, as its velocity tells: braking alone would let it creep down a slope;
and m or rad that it is held against at most, which holds a slope of 7 degrees."""
FIRST_PAUSE, GENTLE_SHARE = 0.5, 0.25
"""s for which nothing is given at first; and the share of the usual braking that is tried after it."""
MOTION_SOURCES = frozenset({"pose", "heading", "velocity", "yaw_rate"})
"""Where a `Suspicion` is of the motion's sensors."""


class Stage(Enum):
    DRIVES = "drives"
    BRAKES = "brakes"
    LETS_GO = "lets go"


@dataclass(frozen=True)
class ProtectiveStop:
    """What is done since a `time` (s), why, at which `share` of the usual braking, with how much kinetic `energy` (J)
    that began, how long the next pause is (s); how far a slow cart has gone (k,), m and rad, and up to when (s)."""

    stage: Stage = Stage.DRIVES
    why: str = ""
    time: float = -math.inf
    share: float = 1.0
    energy: float = math.inf
    pause: float = FIRST_PAUSE
    crept: Array | None = None
    last: float = math.inf

    def after(self, time: float, cart: CartModel, there: Reference, estimate: Estimate, most: float) -> ProtectiveStop:
        """At a later time (s), which never goes back, of a `cart` that is to be `there`, `most` m and rad from it at
        most."""
        error = error_b(there.pose_sb, estimate.motion.pose_sb, cart.rolling.axle_x or 0.0)
        why = _why_misled(estimate) or _why_astray(error, most)
        if not why:
            return DRIVING
        nu, matrix = estimate.motion.velocity, mass_matrix_b(cart.inertia.phi)
        energy = 0.5 * float(cart.basis_b @ nu @ matrix @ cart.basis_b @ nu)
        slow, quick = (0.5 * float(matrix[0, 0]) * speed**2 for speed in (HOLDING_SPEED, MONITORED_SPEED))
        now, crept = self._monitored(time, (energy, quick), why), np.zeros(len(nu))
        if now.stage is Stage.BRAKES and self.crept is not None and energy < slow:
            crept = np.clip(self.crept + max(time - self.last, 0.0) * nu, -MAX_HOLD, MAX_HOLD)
        return replace(now, crept=crept, last=time)

    def _monitored(self, time: float, energies: tuple[float, float], why: str) -> ProtectiveStop:
        """`energies` are the cart's, and from which on it is quick."""
        (energy, quick), lasting = energies, time - self.time
        if self.stage is Stage.LETS_GO and lasting < self.pause:
            return replace(self, why=f"gives nothing: {why}")
        if self.stage is Stage.LETS_GO:
            return ProtectiveStop(Stage.BRAKES, f"stops: {why}", time, GENTLE_SHARE, energy, 2.0 * self.pause)
        if self.stage is Stage.DRIVES:
            return ProtectiveStop(Stage.BRAKES, f"stops: {why}", time, 1.0, energy)
        if lasting < MONITORING_INTERVAL:
            return replace(self, why=f"stops: {why}")
        if energy > max(self.energy, quick):
            return replace(self, stage=Stage.LETS_GO, why=f"gives nothing: {why}", time=time)
        return replace(self, why=f"stops: {why}", time=time, share=1.0, energy=energy)


DRIVING = ProtectiveStop()


def braking_wrench(
    model: CartModel, motion: Motion, time: float, share: float = 1.0, crept: Array | None = None
) -> Array:
    """The planar wrench (3,) in {b} under which velocities fade as they are, so that the cart stays on its curve:
    `nu' = -share nu / T` with T = `BRAKING_TIME_CONSTANT`. What it has `crept` (k,), m and rad, is held against by
    `crept / T²` more."""
    acceleration = -motion.velocity / BRAKING_TIME_CONSTANT
    if crept is not None:
        acceleration = acceleration - crept / BRAKING_TIME_CONSTANT**2
    return wrench_as_it_moves(model, motion, share * acceleration, time)


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
