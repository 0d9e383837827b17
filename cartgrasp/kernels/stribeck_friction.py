"""`effects/stribeck_friction.py`: parameters breakaway, speed, by_wheels.

What acts at {b}'s origin does so as at a wheel that swivels there.
"""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from .jit import compiled
from .rolling import Place, of, rolling
from .situation import Own, Parts, Situation

ORIGIN = (0.0, 0.0, 1.0)


@compiled
def wrench(at: Situation, own: Own, out: Parts) -> None:
    breakaway, by_wheels = own.parameters[0], own.parameters[2]
    unit = _drag(at, ORIGIN, 1.0 - by_wheels, own, out)
    for i in range(3):
        out.by_parameters[i, 2] += breakaway * unit[i]
    total, carried = _total(at)
    if total <= 0.0:
        return
    for wheel in range(len(at.wheels)):
        share = at.loads[wheel] / total
        unit = _drag(at, of(at, wheel), by_wheels * share, own, out)
        for i in range(3):
            out.by_parameters[i, 2] -= breakaway * share * unit[i]
            for j in range(4):
                by_phi = (at.carried[wheel, j] - share * carried[j]) / total
                out.by_phi[i, j] -= breakaway * by_wheels * by_phi * unit[i]


@compiled
def stiction(at: Situation, own: Own, columns: Array) -> int:
    by_wheels = own.parameters[2]
    _hold(at, ORIGIN, 1.0 - by_wheels, own, columns[:2])
    total, _ = _total(at)
    if total <= 0.0 or by_wheels == 0.0:
        return 2
    for wheel in range(len(at.wheels)):
        share = by_wheels * at.loads[wheel] / total
        _hold(at, of(at, wheel), share, own, columns[2 * wheel + 2 : 2 * wheel + 4])
    return 2 * len(at.wheels) + 2


@compiled
def _drag(at: Situation, place: Place, share: float, own: Own, out: Parts) -> tuple[float, float, float]:
    """Adds a share of the drag, that of a wheel there, with partials by velocity, breakaway and speed; returns what the
    wheel would take of each newton of all of it, (3,)."""
    x, y, swivels = place
    unit_x, unit_y, norm = rolling(at, place)
    fade, fading = _fade(unit_x, unit_y, norm, own), own.parameters[1]
    unit = (fade * unit_x, fade * unit_y, fade * (x * unit_y - y * unit_x))
    force = own.parameters[0] * share
    bend = 1.0 / norm + 2.0 * norm / fading**2
    xx, xy, yy = 1.0 / norm - unit_x**2 * bend, -unit_x * unit_y * bend, 1.0 / norm - unit_y**2 * bend
    along, across = (1.0, 0.0, -y), (0.0, swivels, swivels * x)
    by_speed = 2.0 * (unit_x**2 + unit_y**2) * norm**2 / fading**3
    for i in range(3):
        out.value[i] -= force * unit[i]
        out.by_parameters[i, 0] -= share * unit[i]
        out.by_parameters[i, 1] -= force * unit[i] * by_speed
        for j in range(3):
            slope = along[i] * (xx * along[j] + xy * across[j]) + across[i] * (xy * along[j] + yy * across[j])
            out.by_velocity[i, j] -= force * fade * slope
    return unit


@compiled
def _hold(at: Situation, place: Place, share: float, own: Own, columns: Array) -> None:
    """Writes the two wrenches that a wheel there may give near standstill."""
    x, y, swivels = place
    unit_x, unit_y, norm = rolling(at, place)
    level = own.parameters[0] * share * _fade(unit_x, unit_y, norm, own) * (1.0 - unit_x**2 - unit_y**2)
    columns[0, 0], columns[0, 2] = level, -y * level
    columns[1, 1], columns[1, 2] = swivels * level, swivels * x * level


@compiled
def _fade(unit_x: float, unit_y: float, norm: float, own: Own) -> float:
    return math.exp(-(unit_x**2 + unit_y**2) * norm**2 / own.parameters[1] ** 2)


@compiled
def _total(at: Situation) -> tuple[float, tuple[float, float, float, float]]:
    """The sum of all wheel loads, N, with its partials by phi."""
    load, mass, first_x, first_y = 0.0, 0.0, 0.0, 0.0
    for wheel in range(len(at.wheels)):
        load += at.loads[wheel]
        mass, first_x = mass + at.carried[wheel, 0], first_x + at.carried[wheel, 1]
        first_y += at.carried[wheel, 2]
    return load, (mass, first_x, first_y, 0.0)
