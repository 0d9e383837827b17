"""`effects/stribeck_friction.py`: parameters breakaway, speed, by_wheels; a heading of each listed
caster.

What acts at {b}'s origin does so as what rolls anywhere.
"""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from ..casters import heading_rates, settled_headings
from ..jit import compiled
from ..rolling import (
    Rolling,
    WheelPlace,
    add_by_heading,
    add_by_velocity,
    hold,
    hold_anywhere,
    place_of,
    rolling,
    rolling_anywhere,
)
from ..situation import EffectValues, KernelSituation, Parts

memory_rate, settled = heading_rates, settled_headings


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    breakaway, by_wheels = own.parameters[0], own.parameters[2]
    unit = _drag(rolling_anywhere(at, 0.0, 0.0), (0.0, 0.0, -1), 1.0 - by_wheels, own, out)
    for i in range(3):
        out.by_parameters[i, 2] += breakaway * unit[i]
    total, carried = _total(at)
    if total <= 0.0:
        return
    for wheel in range(len(at.wheels)):
        share = at.loads[wheel] / total
        unit = _drag(rolling(at, own, wheel), place_of(at, own, wheel), by_wheels * share, own, out)
        for i in range(3):
            out.by_parameters[i, 2] -= breakaway * share * unit[i]
            for j in range(4):
                by_phi = (at.carried[wheel, j] - share * carried[j]) / total
                out.by_phi[i, j] -= breakaway * by_wheels * by_phi * unit[i]


@compiled
def stiction(at: KernelSituation, own: EffectValues, columns: Array) -> int:
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
def _drag(way: Rolling, place: WheelPlace, share: float, own: EffectValues, out: Parts) -> tuple[float, float, float]:
    """Adds a share of the drag, that of what rolls so at a place, with partials by velocity, heading, breakaway and
    speed; returns what it would take of each newton of all of it, (3,)."""
    x, y, _ = place
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
    less = 2.0 * way.speed * way.speed_by_heading / fading**2
    turned = (way.by_heading[0] - less * way.x, way.by_heading[1] - less * way.y)
    add_by_heading(place, force * fade, turned, out)
    return unit


@compiled
def _fade(way: Rolling, own: EffectValues) -> float:
    return math.exp(-(way.x**2 + way.y**2) * way.norm**2 / own.parameters[1] ** 2)


@compiled
def _total(at: KernelSituation) -> tuple[float, tuple[float, float, float, float]]:
    """The sum of all wheel loads, N, with its partials by phi."""
    load, mass, first_x, first_y = 0.0, 0.0, 0.0, 0.0
    for wheel in range(len(at.wheels)):
        load += at.loads[wheel]
        mass, first_x = mass + at.carried[wheel, 0], first_x + at.carried[wheel, 1]
        first_y += at.carried[wheel, 2]
    return load, (mass, first_x, first_y, 0.0)
