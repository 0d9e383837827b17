"""Drag of a wheel against its own rolling, in proportion to its load.

A fixed wheel rolls along {b}'s x, a caster along the velocity of its pivot; the force there, carried to {b}'s origin,
is the transpose of what takes (u, w, r) to that velocity.
"""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from .jit import compiled
from .situation import Parts, Situation

Place = tuple[float, float, float]
"""The place of a wheel: x and y in {b}, m, and 1 for a caster or 0 for a fixed wheel."""


@compiled
def drag(at: Situation, wheel: int, coefficient: float, out: Parts) -> tuple[float, float, float]:
    """Adds the drag of one wheel with partials by velocity and phi; returns the wrench (3,) of a unit force along its
    rolling."""
    place = of(at, wheel)
    x, y, swivels = place
    unit_x, unit_y, norm = rolling(at, place)
    unit = (unit_x, unit_y, x * unit_y - y * unit_x)
    force = coefficient * at.loads[wheel]
    xx, xy, yy = (1.0 - unit_x**2) / norm, -unit_x * unit_y / norm, (1.0 - unit_y**2) / norm
    along, across = (1.0, 0.0, -y), (0.0, swivels, swivels * x)
    for i in range(3):
        out.value[i] -= force * unit[i]
        for j in range(3):
            slope = along[i] * (xx * along[j] + xy * across[j]) + across[i] * (xy * along[j] + yy * across[j])
            out.by_velocity[i, j] -= force * slope
        for j in range(4):
            out.by_phi[i, j] -= coefficient * unit[i] * at.carried[wheel, j]
    return unit


@compiled
def hold(at: Situation, wheel: int, coefficient: float, columns: Array) -> None:
    """Writes the two wrenches that one wheel may give near standstill."""
    place = of(at, wheel)
    x, y, swivels = place
    unit_x, unit_y, _ = rolling(at, place)
    level = coefficient * at.loads[wheel] * (1.0 - unit_x**2 - unit_y**2)
    columns[2 * wheel, 0], columns[2 * wheel, 2] = level, -y * level
    columns[2 * wheel + 1, 1], columns[2 * wheel + 1, 2] = swivels * level, swivels * x * level


@compiled
def of(at: Situation, wheel: int) -> Place:
    return at.wheels[wheel, 0], at.wheels[wheel, 1], at.wheels[wheel, 2]


@compiled
def rolling(at: Situation, place: Place) -> tuple[float, float, float]:
    """Direction in which a wheel there rolls, shorter than 1 near standstill, and its smoothed speed."""
    x, y, swivels = place
    u, w, r = at.velocity[0], at.velocity[1], at.velocity[2]
    speed_x = u - y * r
    speed_y = swivels * (w + x * r)
    norm = math.sqrt(speed_x**2 + speed_y**2 + at.smoothing_speed**2)
    return speed_x / norm, speed_y / norm, norm
