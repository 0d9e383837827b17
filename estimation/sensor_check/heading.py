"""Headings against the direction of travel: wheels that don't slip sideways let a cart go only where it heads.

If the true heading is theta' + psi, with theta' a reading of what was recorded, the sideways displacements
-sin(psi) A + cos(psi) B are noise, where A and B are those along and across theta', beside what turns about an axle
elsewhere. To and fro look alike, so psi is one of half a turn.

A heading may also drift, as a gyro's does. Sideways displacements, divided by those ahead, tell its error at any time
but for what slips with speed and turning, and where that grows with the clock, whatever the cart does, the heading is
put back on what it was at first.
"""

from __future__ import annotations

import math
from dataclasses import replace
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
DRIFT_SIGMAS, MIN_DRIFT_ANGLE = 8.0, 0.01
"""Standard deviations of the drift, and rad of it over the log, beyond both of which it is one. Of 40 made logs, half
of them with wheels that slip, are turned or drag on one side, none is beyond 0.7 deviations."""
MAX_DRIFT_FITS = 5
"""Fits at most, each of which is right for small angles."""


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


class Drift(NamedTuple):
    """A heading that leaves the true one: its rate and standard deviation, rad/s, and for how long (s) it was seen."""

    rate: float
    std: float
    span: float


def heading_drift(log: RunLog, cart: CartModel) -> Drift | None:
    """None of carts that may go any way, or can't turn, and where there is no drift or too little is seen."""
    track = Track.of(log)
    windows = Windows.over(track.time)
    if cart.constraints.axle_x is None or cart.constraints.no_rotation or windows is None:
        return None
    found, whole = _drift(track, windows), 0.0
    for _ in range(MAX_DRIFT_FITS):
        if found is None:
            return None
        whole += found.rate
        if not abs(whole) > max(DRIFT_SIGMAS * found.std, MIN_DRIFT_ANGLE / found.span):
            return None
        if abs(found.rate) < found.std:
            break
        found = _drift(replace(track, heading=track.heading - whole * (track.time - track.time[0])), windows)
    return None if found is None else found._replace(rate=whole)


def _drift(track: Track, windows: Windows) -> Drift | None:
    """What a small drift looks like."""
    sums = windows.on(track.time)
    seen, kept = window_displacements(track, sums), sums.covered
    if seen is None:
        return None
    (along, across), turned = seen[0].T, seen[1]
    time = sums.integral(track.time)[kept] / sums.integral(np.ones(len(track.time)))[kept]
    slips = along * turned
    columns = np.column_stack([along, turned, slips, np.abs(slips), (time - time.mean()) * along])
    fit = np.linalg.lstsq(columns, across)[0]
    left = across - columns @ fit
    rows = max(independent_rows(left) - columns.shape[1], 1.0)
    variance = np.linalg.pinv(columns.T @ columns)[-1, -1] * float(left @ left) / rows
    return Drift(-float(fit[-1]), math.sqrt(max(variance, 0.0)), float(time[-1] - time[0]))


def without_drift(log: RunLog, found: Drift | None) -> RunLog:
    """The log, with a heading that drifts put back."""
    if found is None:
        return log
    heading = wrap_angle(log.pose[:, 2] - found.rate * (log.time - log.time[0]))
    return replace(log, pose=np.column_stack([log.pose[:, :2], heading]))


def drift_suspicions(found: Drift | None) -> tuple[Suspicion, ...]:
    """`offset` of a heading that drifts."""
    if found is None:
        return ()
    words = (
        f"theta drifts by {found.rate:.2g} ± {found.std:.1g} rad/s against the way the cart goes, "
        f"{found.rate * found.span:.2g} rad in all, as a gyro's heading does; it is put back: take it from what sees "
        "the floor, or the room"
    )
    return (Suspicion("offset", "heading", 0.99, found.rate, words, put_right=True),)
