"""A log cut into manoeuvres: stretches of one direction and one sense of turning."""

from __future__ import annotations

import numpy as np

from cartgrasp.wheels import FIXED

from ..batch.smooth_motion import SmoothMotion
from ..batch.wrench_regression import WrenchRegression

SHORTEST, USUAL, LONGEST = 1.5, 2.5, 6.0
"""s: shorter stretches belong to the one before, longer ones are cut."""
FEWEST = 8
"""Into which a short log is cut, where they are no shorter."""
MOVING = 0.03
"""m/s."""
TURNING = 0.05
"""rad/s."""
ROLLING, SETTLING, TRAILS = 0.02, 0.05, 3.0
"""m/s, m: below, and so soon after, a wheel's friction has not the value that it keeps. A caster that has to turn round
takes some times its trail."""
HELD_OUT = 3
"""One manoeuvre of so many is kept out of fits."""


def manoeuvres(motion: SmoothMotion, turns: bool) -> np.ndarray:
    """The number of its manoeuvre for each row (n,)."""
    speed, time = motion.velocity[:, 0], motion.time
    kind = np.where(np.abs(speed) < MOVING, 0.0, np.sign(speed))
    if turns:
        rate = motion.velocity[:, -1]
        kind = 3 * kind + np.where(np.abs(rate) < TURNING, 0.0, np.sign(rate))
    share = (time[-1] - time[0]) / FEWEST
    longest, shortest = np.clip(share, SHORTEST, LONGEST), np.clip(share, SHORTEST, USUAL)
    number, count, began = np.zeros(len(time), dtype=int), 0, time[0]
    for i in range(1, len(time)):
        lasted = time[i] - began
        if (kind[i] != kind[i - 1] and lasted >= shortest) or lasted >= longest:
            count, began = count + 1, time[i]
        number[i] = count
    return number


def held_out(number: np.ndarray) -> np.ndarray:
    """Rows (n,) that fits on training stretches do not see."""
    return np.asarray(number % HELD_OUT == HELD_OUT - 1)


def settled(regression: WrenchRegression) -> np.ndarray:
    """Rows (n,) on which no fixed wheel, nor the axle's middle, is near rest or turns round, or has just done so."""
    motion, wheels = regression.motion, regression.cart.wheels
    turning = motion.velocity[:, -1] if motion.velocity.shape[1] > 1 else np.zeros(len(motion.time))
    rolling = motion.velocity[:, :1] - np.outer(turning, [0.0, *(w.y for w in wheels if w.kind == FIXED)])
    if motion.velocity.shape[1] > 2:
        rolling = motion.speed[:, None]
    turned = np.diff(np.sign(rolling), axis=0, prepend=np.sign(rolling[:1])) != 0
    slow = np.any(turned | (np.abs(rolling) < ROLLING), axis=1)
    travelled = np.cumsum(motion.speed * np.diff(motion.time, prepend=motion.time[0]))
    rested = np.maximum.accumulate(np.where(slow, travelled, 0.0))
    settling = max([SETTLING, *(TRAILS * w.trail for w in wheels if w.kind != FIXED)])
    return np.asarray(~slow & (travelled - rested > settling))
