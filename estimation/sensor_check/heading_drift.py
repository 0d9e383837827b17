"""A heading that drifts against the way the cart goes, as a gyro's does.

Fixed wheels go where they head, but for what slips with speed and turning. So sideways displacements, divided by those
ahead, tell the heading's error at any time, and where that grows with the clock, whatever the cart does, the heading is
put back on what it was at first.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from cartgrasp.frames import wrap_angle
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from .evidence import independent_rows
from .heading import window_displacements
from .suspicion import Suspicion
from .windows import Track, Windows

DRIFT_SIGMAS, MIN_DRIFT_ANGLE = 8.0, 0.01
"""Standard deviations of the drift, and rad of it over the log, beyond both of which it is one. Of 40 made logs, half
of them with wheels that slip, are turned or drag on one side, none is beyond 0.7 deviations."""
MAX_DRIFT_FITS = 5
"""Fits at most, each of which is right for small angles."""


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
