"""What poses alone tell a picture: velocity, and how casters stand.

A pivot that moves by s along the direction β turns its caster's heading ψ, all in {s}, so that
tan((ψ' − β) / 2) = tan((ψ − β) / 2) exp(−s / trail): the tractrix, exact for a straight step of any length.
"""

from __future__ import annotations

import math

import numpy as np

from ..frames import Array, rotation_planar
from ..model import CartModel
from ..wheels import CASTER, DEFAULT_TRAIL

VELOCITY_WINDOW = 0.1
"""s before and after an instant whose poses tell its velocity."""
MIN_PIVOT_MOTION_FRACTION = 0.2
"""Share of the trail that a pivot must move before its caster turns, so that noise turns no caster at rest."""


def velocity_of_poses(time: Array, pose: Array) -> Array:
    """(n, 3) in {s}: the mean of the poses within `VELOCITY_WINDOW` after an instant less that of those before it, over
    their mean times; NaN where poses are missing."""
    known = np.asarray(np.isfinite(pose).all(axis=1))
    rows = np.where(known[:, None], np.column_stack([time - time[0], pose]), 0.0)
    rows[known, 3] = np.unwrap(rows[known, 3])
    sums = np.vstack([np.zeros(5), np.cumsum(np.column_stack([rows, known]), axis=0)])
    here, step = np.arange(len(time)), float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    window = max(VELOCITY_WINDOW, 1.001 * step)
    first, last = np.searchsorted(time, time - window), np.searchsorted(time, time + window, side="right")
    with np.errstate(invalid="ignore", divide="ignore"):
        before, after = (
            total[:, :4] / total[:, 4:] for total in (sums[here + 1] - sums[first], sums[last] - sums[here])
        )
        found = np.asarray((after - before)[:, 1:] / (after - before)[:, :1])
    found[~np.isfinite(found).all(axis=1) | ~known] = np.nan
    return found


def trailing_headings(pose: Array, cart: CartModel) -> Array | None:
    """Headings (n, casters) in {b}, as if each caster trailed its first motion; None without casters."""
    casters = [wheel for wheel in cart.wheels if wheel.kind == CASTER]
    if not casters:
        return None
    rotation = rotation_planar(pose[:, 2])
    headings = [
        _trailing(pose[:, :2] + rotation @ np.array([wheel.x, wheel.y]), wheel.trail or DEFAULT_TRAIL)
        for wheel in casters
    ]
    return np.stack(headings, axis=1) - pose[:, 2:]


def _trailing(pivot: Array, trail: float) -> Array:
    """Heading (n,) in {s} of a caster whose pivot goes through (n, 2)."""
    rows = np.flatnonzero(np.isfinite(pivot).all(axis=1))
    known: list[int] = []
    found: list[float] = []
    at: list[float] | None = None
    for row, point in zip(rows.tolist(), pivot[rows].tolist(), strict=True):
        at = at or point
        moved = math.dist(at, point)
        if moved < MIN_PIVOT_MOTION_FRACTION * trail:
            continue
        along = math.atan2(point[1] - at[1], point[0] - at[0])
        off = (found[-1] if found else along) - along
        found.append(along + 2 * math.atan(math.tan(off / 2) * math.exp(-moved / trail)))
        known.append(row)
        at = point
    if not found:
        return np.full(len(pivot), np.nan)
    return np.asarray(np.interp(np.arange(len(pivot)), known, np.unwrap(found)))
