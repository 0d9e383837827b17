"""Headings against the direction of travel: wheels that don't slip sideways let a cart go only where it heads.

If the true heading is theta' + psi, with theta' a reading of what was recorded, the sideways displacements
-sin(psi) A + cos(psi) B are noise, where A and B are those along and across theta', beside what turns about an axle
elsewhere. Each reading turns displacements, which keeps their volume, so noise of unknown size in what goes sideways
is the evidence. To and fro look alike, so psi is one of half a turn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array, wrap_angle
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from ..evidence import independent_rows, log_normal_density, probabilities
from ..prior import FAULTS, MISALIGNED, TRUEST
from ..suspicion import SURE, TOLD, Suspicion
from ..weak_form import Bumps
from .track import Track

WIDTH = 0.8
"""s: of the bumps."""
FEWEST = 8
"""Rows."""
DEGREE = math.pi / 180
NODES = np.concatenate([-np.geomspace(1, 1e-6, 300), [0.0], np.geomspace(1e-6, 1, 300)]) * math.pi / 2
"""rad about the best offset, dense where evidence may be sharp."""


@dataclass(frozen=True)
class Reading:
    """One way to read poses: the kind of its fault ("" for none), the factor of theta, the offset (rad) that it means,
    None for any, its probability before a log is seen, and words."""

    kind: str
    factor: float
    offset: float | None
    prior: float
    words: str


def readings(rolling: float = 0.0) -> tuple[Reading, ...]:
    """The sound one first, for wheels that roll at an angle (rad) to {b}'s x."""
    faults, right = FAULTS["pose"], rolling + math.pi / 2
    return (
        Reading("", 1.0, rolling, 1 - sum(faults.values()), ""),
        Reading("unit", DEGREE, rolling, faults["degrees"], "theta is in degrees; multiply it by 0.0174533"),
        Reading(
            "sign",
            -1.0,
            rolling,
            faults["reversed"],
            "theta (or x, or y) has the opposite sign; multiply it by -1",
        ),
        Reading("axes", -1.0, right, faults["swapped"], "x and y are swapped; exchange them"),
        Reading("axes", 1.0, right, faults["quarter turn"], "theta is that of the cart's side; turn it by 90°"),
        Reading("frame", 1.0, None, faults["turned"], "the tracked frame is turned against the cart's"),
    )


@dataclass(frozen=True)
class HeadingCheck:
    """Probabilities (k,) of `readings`, and the offset (rad, k) that fits each best."""

    probability: Array
    offset: Array


def heading_check(log: RunLog, cart: CartModel) -> HeadingCheck | None:
    """None for carts that may go any way, or where too little is seen."""
    known = readings(cart.rolling.angle)
    if cart.constraints.axle_x is None:
        return None
    factors = sorted({one.factor for one in known})
    seen = {factor: _displacements(_read(log, factor)) for factor in factors}
    parts = [part for part in seen.values() if part is not None]
    if len(parts) < len(factors):
        return None
    best = min((_best_left(*part) for part in parts), key=lambda left: float(left @ left))
    rows = independent_rows(best)
    found = [_evidence(seen[one.factor], rows, one) for one in known]
    log_evidence, offset = np.array(found).T
    return HeadingCheck(probabilities(log_evidence, np.array([one.prior for one in known])), offset)


def _read(log: RunLog, factor: float) -> Track:
    pose = log.pose.copy()
    pose[:, 2] *= factor
    return Track.of(replace(log, pose=pose))


def _displacements(track: Track) -> tuple[Array, Array, float] | None:
    """Along and across (k,) beside what turns, and the sum of squares of all."""
    if len(track.time) < FEWEST:
        return None
    bumps = Bumps.over(track.time, track.width(WIDTH))
    sums = bumps.on(track.time)
    if sums.covered.sum() < FEWEST:
        return None
    both = np.column_stack(track.along(sums))[sums.covered]
    turned = sums.along(np.ones_like(track.time), track.heading)[sums.covered]
    size = float((both**2).sum())
    if turned @ turned > 0:
        both = both - np.outer(turned, turned @ both) / (turned @ turned)
    return both[:, 0], both[:, 1], size


def _best_left(along: Array, across: Array, _: float) -> Array:
    """What is left sideways (k,) at the offset that leaves least."""
    offset = _best_offset(along, across)
    return np.asarray(math.cos(offset) * across - math.sin(offset) * along)


def _best_offset(along: Array, across: Array) -> float:
    return 0.5 * math.atan2(2 * float(along @ across), float(along @ along - across @ across))


def _evidence(part: tuple[Array, Array, float] | None, rows: float, reading: Reading) -> tuple[float, float]:
    """Log evidence and best offset of a reading."""
    if part is None:
        return -np.inf, 0.0
    along, across, size = part
    best = _best_offset(along, across)
    offset = best + NODES
    c, s = np.cos(offset), np.sin(offset)
    left = c**2 * (across @ across) - 2 * c * s * (along @ across) + s**2 * (along @ along) + TRUEST**2 * size
    log = -0.5 * rows * np.log(np.maximum(left, np.finfo(float).tiny))
    if reading.offset is None:
        prior = np.full_like(offset, -math.log(math.pi))
    else:
        prior = log_normal_density(_half_turn(offset - reading.offset), MISALIGNED)
    height = log + prior
    top = float(height.max())
    return top + math.log(float(np.trapezoid(np.exp(height - top), offset))), float(_half_turn(np.array(best)))


def _half_turn(angle: Array) -> Array:
    """The same line's angle in [-pi/2, pi/2)."""
    return wrap_angle(2 * angle) / 2


def pose_suspicions(check: HeadingCheck | None) -> tuple[Suspicion, ...]:
    """`unit`, `sign`, `axes` and `frame` of poses."""
    if check is None:
        return ()
    told = []
    for kind in ("unit", "sign", "axes", "frame"):
        which = [i for i, one in enumerate(readings()) if one.kind == kind]
        probability = float(check.probability[which].sum())
        if probability < TOLD:
            continue
        most = max(which, key=lambda i: float(check.probability[i]))
        reading, degrees = readings()[most], check.offset[most] / DEGREE
        cure = f" by {degrees:.1f}° or so; give its pose in the cart's frame" if kind == "frame" else ""
        words = f"the cart goes sideways as its wheels can't, unless {reading.words}{cure}"
        factor = reading.factor if reading.factor != 1.0 else None
        told.append(Suspicion(kind, "pose", probability, factor, words))
    return tuple(told)


def poses_put_right(log: RunLog, check: HeadingCheck | None) -> tuple[RunLog, ...]:
    """What the log may be where a reading is sure, the log itself where none is. To and fro look alike, and so do a
    reversed theta, x or y: velocities and wrenches must tell which."""
    if check is None or check.probability[1:].max() < SURE:
        return (log,)
    most = int(check.probability.argmax())
    reading, offset = readings()[most], float(check.offset[most])
    if reading.kind == "unit":
        return (_with_poses(log, (1.0, 1.0, DEGREE)),)
    if reading.kind == "sign":
        return tuple(_with_poses(log, signs) for signs in ((1, 1, -1), (1, -1, 1), (-1, 1, 1)))
    if reading.factor < 0:
        swapped = replace(log, pose=log.pose[:, [1, 0, 2]])
        return swapped, _with_poses(swapped, (-1, -1, 1))
    turn = offset if reading.kind == "frame" else math.copysign(math.pi / 2, offset)
    return _with_poses(log, (1, 1, 1), turn), _with_poses(log, (1, 1, 1), turn + math.pi)


def _with_poses(log: RunLog, factors: tuple[float, float, float], turn: float = 0.0) -> RunLog:
    return replace(log, pose=log.pose * np.array(factors) + np.array([0.0, 0.0, turn]))
