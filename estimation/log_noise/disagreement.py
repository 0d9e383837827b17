"""How far velocities and poses tell different motions, where they come from two sensors: late, scaled or turned ones
are as quiet as any, and wrong for long."""

from __future__ import annotations

import numpy as np

from cartgrasp.frames import Array

COMPARED_SPAN = 0.5
"""s over which velocities are summed and held against the way between two poses."""
MIN_COMPARED_SPANS = 12
"""Spans that tell how far they usually are apart."""
SPREAD_QUANTILE, SPREAD_QUANTILE_SIGMAS = 0.9, 1.645
"""Quantile of normal numbers' sizes, and how many deviations it is: single glitches don't reach it."""
DISAGREEMENT_VARIANCE_RATIO = 2.0
"""Times the variance that noise alone makes, beyond which they disagree."""


def velocity_noise(time: Array, place: Array, velocity: Array, white: tuple[float, float]) -> float:
    """Standard deviation of white noise of a velocity (n,) that spoils ways as much as they differ from those between
    places (n,); of places and velocities that agree, what they have: `white`."""
    of_place, of_velocity = white
    seen = np.isfinite(place) & np.isfinite(velocity)
    time, place, velocity = time[seen], place[seen], velocity[seen]
    if len(time) < MIN_COMPARED_SPANS:
        return of_velocity
    step = float(np.median(np.diff(time)))
    ends = np.flatnonzero(np.diff(np.floor((time - time[0]) / COMPARED_SPAN), prepend=-1.0))
    whole = np.diff(time[ends]) < 2.0 * COMPARED_SPAN  # without a hole
    way = np.append(0.0, np.cumsum(np.diff(time) * (velocity[1:] + velocity[:-1]) / 2.0))
    off = (np.diff(place[ends]) - np.diff(way[ends]))[whole]
    if len(off) < MIN_COMPARED_SPANS:
        return of_velocity
    spread = float(np.quantile(np.abs(off), SPREAD_QUANTILE) / SPREAD_QUANTILE_SIGMAS) ** 2
    foretold = 2.0 * of_place**2 + of_velocity**2 * step * COMPARED_SPAN
    more = (spread - foretold) / (step * COMPARED_SPAN) if spread > DISAGREEMENT_VARIANCE_RATIO * foretold else 0.0
    return float(np.sqrt(of_velocity**2 + more))
