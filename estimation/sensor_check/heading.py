"""Headings against the direction of travel: wheels that don't slip sideways let a cart go only where it heads.

If the true heading is theta' + psi, with theta' a reading of what was recorded, the sideways displacements
-sin(psi) A + cos(psi) B are noise, where A and B are those along and across theta', beside what turns about an axle
elsewhere. To and fro look alike, so psi is one of half a turn.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array, wrap_angle
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from ..log_noise.log_noise import noise_floor
from .evidence import WRONG_HEADING_ODDS, independent_rows, reading_probabilities
from .suspicion import REPORT_PROBABILITY, Suspicion
from .windows import MIN_WINDOWS, Sums, Track, Windows

RAD_PER_DEGREE, RIGHT_ANGLE = math.pi / 180, math.pi / 2
HEADING_READINGS: tuple[tuple[str, float, float | None, str], ...] = (
    ("", 1.0, 0.0, ""),
    ("unit", RAD_PER_DEGREE, 0.0, "theta is in degrees: multiply it by 0.0174533"),
    ("unit", 1 / RAD_PER_DEGREE, 0.0, "theta is 57 times too small, turned into radians twice: multiply it by 57.2958"),
    ("sign", -1.0, 0.0, "theta (or x, or y) has the opposite sign: multiply it by -1"),
    ("axes", -1.0, RIGHT_ANGLE, "x and y are swapped: exchange them"),
    ("axes", 1.0, RIGHT_ANGLE, "theta is that of the cart's side: turn it by 90°"),
    ("frame", 1.0, None, "the tracked frame is turned against the cart's by {:.0f}° or so: give its pose there"),
)
"""Kind, factor of theta, offset (rad; None: any), and words of the ways in which poses may be meant, the sound one
first."""
MAX_MISALIGNMENT = 0.1
"""rad, within which an offset is one that an effect of the vocabulary tells (`wheel_misalignment`)."""
MIN_MOTION_NOISE_RATIO = 4.0
"""Times the square of what white noise of the places alone makes: a cart that goes no farther says nothing."""
KNOWN_OFFSET_FRACTION = 2 * MAX_MISALIGNMENT / math.pi
"""Share of all offsets that lie so near to a known one."""


def heading_suspicions(log: RunLog, cart: CartModel) -> tuple[Suspicion, ...]:
    """`unit`, `sign`, `axes` and `frame` of poses; none of carts that may go any way, or where too little is seen."""
    if cart.constraints.axle_x is None or cart.constraints.no_rotation:
        return ()
    seen = {factor: displacements(Track.of(log, factor)) for factor in {one[1] for one in HEADING_READINGS}}
    offsets, left = list[float](), list[tuple[Array, float]]()
    for _, factor, known, _ in HEADING_READINGS:
        part = seen[factor]
        if part is None:
            return ()
        along, across, size = part[:3]
        psi = 0.5 * math.atan2(2 * float(along @ across), float(along @ along - across @ across))  # leaves least aside
        if known is not None:
            right = known + float(cart.rolling.angle)
            psi = right + float(np.clip(_half_turn(psi - right), -MAX_MISALIGNMENT, MAX_MISALIGNMENT))
        offsets.append(_half_turn(psi))
        left.append((math.cos(psi) * across - math.sin(psi) * along, size))
    odds = np.array(
        [1.0]
        + [WRONG_HEADING_ODDS * (KNOWN_OFFSET_FRACTION if one[2] is None else 1.0) for one in HEADING_READINGS[1:]]
    )
    found = reading_probabilities(left, odds)
    told = []
    for kind in ("unit", "sign", "axes", "frame"):
        which = [i for i, one in enumerate(HEADING_READINGS) if one[0] == kind]
        most = max(which, key=lambda i: float(found[i]))
        if found[which].sum() >= REPORT_PROBABILITY:
            words = HEADING_READINGS[most][3].format(math.degrees(offsets[most]))
            times = HEADING_READINGS[most][1] if kind in ("unit", "sign") else None
            words = f"the cart goes sideways as its wheels can't, unless {words}"
            told.append(Suspicion(kind, "pose", float(found[which].sum()), times, words))
    return tuple(told)


class Displacements(NamedTuple):
    """Displacements (k,) of windows along and across the heading, beside what turns about a point; the sum of squares
    of all; where on the heading's axis that point is (m), which hardly goes sideways, and its standard deviation."""

    along: Array
    across: Array
    size: float
    axle: float
    axle_std: float


def window_displacements(track: Track, sums: Sums) -> tuple[Array, Array] | None:
    """Displacements (k, 2) of the windows that samples cover, along and across the heading, and how far (k,) each
    turned; None where too little is seen."""
    c, s, kept = np.cos(track.heading), np.sin(track.heading), sums.covered
    along = sums.along(track.x, c) + sums.along(track.y, s)
    across = sums.along(track.y, c) - sums.along(track.x, s)
    both = np.column_stack([along, across])[kept]
    noise = sum(noise_floor(place) ** 2 for place in (track.x, track.y)) * sums.rate_noise(kept)
    if kept.sum() < MIN_WINDOWS or float((both**2).sum()) <= MIN_MOTION_NOISE_RATIO * noise:
        return None
    return both, sums.along(track.heading)[kept]


def displacements(track: Track) -> Displacements | None:
    """None where too little is seen. Where nothing turns, the point may be anywhere."""
    windows = Windows.over(track.time)
    seen = None if windows is None else window_displacements(track, windows.on(track.time))
    if seen is None:
        return None
    both, turned = seen
    size, turning = float((both**2).sum()), float(turned @ turned)
    if turning <= 0:
        return Displacements(both[:, 0], both[:, 1], size, 0.0, math.inf)
    beside = turned @ both / turning
    both = both - np.outer(turned, beside)
    left, rows = float(both[:, 1] @ both[:, 1]), max(independent_rows(both[:, 1]), 1.0)
    return Displacements(both[:, 0], both[:, 1], size, -float(beside[1]), math.sqrt(left / rows / turning))


def _half_turn(angle: float) -> float:
    """The same line's angle (rad), at most a quarter turn."""
    return float(wrap_angle(np.array(2 * angle))) / 2
