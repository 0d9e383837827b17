"""`effects/stribeck_friction.py`: parameters breakaway, speed, by_wheels; a heading of each listed
caster.

What acts at {b}'s origin does so as what rolls anywhere.
"""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from .jit import compiled
from .rolling import Rolling, add_by_velocity, caster_of, hold, hold_anywhere, rolling, rolling_anywhere
from .situation import Own, Parts, Situation


@compiled
def wrench(at: Situation, own: Own, out: Parts) -> None:
    breakaway, by_wheels = own.parameters[0], own.parameters[2]
    unit = _drag(rolling_anywhere(at, 0.0, 0.0), (0.0, 0.0, -1), 1.0 - by_wheels, own, out)
    for i in range(3):
        out.by_parameters[i, 2] += breakaway * unit[i]
    total, carried = _total(at)
    if total <= 0.0:
        return
    for wheel in range(len(at.wheels)):
        share = at.loads[wheel] / total
        place = at.wheels[wheel, 0], at.wheels[wheel, 1], caster_of(at, own, wheel)
        unit = _drag(rolling(at, own, wheel), place, by_wheels * share, own, out)
        for i in range(3):
            out.by_parameters[i, 2] -= breakaway * share * unit[i]
            for j in range(4):
                by_phi = (at.carried[wheel, j] - share * carried[j]) / total
                out.by_phi[i, j] -= breakaway * by_wheels * by_phi * unit[i]


@compiled
def stiction(at: Situation, own: Own, columns: Array) -> int:
    breakaway, by_wheels = own.parameters[0], own.parameters[2]
    way = rolling_anywhere(at, 0.0, 0.0)
    still = 1.0 - way.x**2 - way.y**2
    hold_anywhere(0.0, 0.0, breakaway * (1.0 - by_wheels) * _fade(way, own) * still, columns[:2])
    total, _ = _total(at)
    if total <= 0.0 or by_wheels == 0.0:
        return 2
    for wheel in range(len(at.wheels)):
        share = by_wheels * at.loads[wheel] / total
        hold(at, own, wheel, breakaway * share * _fade(rolling(at, own, wheel), own), columns[2:])
    return 2 * len(at.wheels) + 2


@compiled
def _drag(
    way: Rolling, place: tuple[float, float, int], share: float, own: Own, out: Parts
) -> tuple[float, float, float]:
    """Adds a share of the drag, that of what rolls so at x and y, and remembers its heading at the third number, with
    partials by velocity, heading, breakaway and speed; returns what it would take of each newton of all of it, (3,)."""
    x, y, k = place
    fade, fading = _fade(way, own), own.parameters[1]
    unit = (fade * way.x, fade * way.y, fade * (x * way.y - y * way.x))
    force = own.parameters[0] * share
    bend = 2.0 * way.norm / fading**2
    (xx, xy), (yx, yy) = way.along
    along = (
        (xx - way.x * way.x * bend, xy - way.x * way.y * bend),
        (yx - way.x * way.y * bend, yy - way.y * way.y * bend),
    )
    add_by_velocity(x, y, force * fade, along, out)
    by_speed = 2.0 * (way.x**2 + way.y**2) * way.norm**2 / fading**3
    for i in range(3):
        out.value[i] -= force * unit[i]
        out.by_parameters[i, 0] -= share * unit[i]
        out.by_parameters[i, 1] -= force * unit[i] * by_speed
    if k >= 0:
        less = 2.0 * way.speed * way.speed_by_heading / fading**2
        turned_x, turned_y = fade * (way.by_heading[0] - less * way.x), fade * (way.by_heading[1] - less * way.y)
        out.by_memory[0, k] -= force * turned_x
        out.by_memory[1, k] -= force * turned_y
        out.by_memory[2, k] -= force * (x * turned_y - y * turned_x)
    return unit


@compiled
def _fade(way: Rolling, own: Own) -> float:
    return math.exp(-(way.x**2 + way.y**2) * way.norm**2 / own.parameters[1] ** 2)


@compiled
def _total(at: Situation) -> tuple[float, tuple[float, float, float, float]]:
    """The sum of all wheel loads, N, with its partials by phi."""
    load, mass, first_x, first_y = 0.0, 0.0, 0.0, 0.0
    for wheel in range(len(at.wheels)):
        load += at.loads[wheel]
        mass, first_x = mass + at.carried[wheel, 0], first_x + at.carried[wheel, 1]
        first_y += at.carried[wheel, 2]
    return load, (mass, first_x, first_y, 0.0)
