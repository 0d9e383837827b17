"""Drag of a wheel against its own rolling, in proportion to its load.

A fixed wheel rolls along {b}'s x, a caster along its heading; one that stands for all wheels of a cart that lists none,
and may roll anywhere, along its velocity. The force there, carried to {b}'s origin, is the transpose of what takes
(u, w, r) to the velocity of the wheel's place.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cartgrasp.frames import Array

from .casters import pivot_velocity
from .jit import compiled
from .situation import EffectValues, KernelSituation, Parts

WheelPlace = tuple[float, float, int]
"""x and y of a wheel in {b}, m, and which of the headings that an effect remembers is its; -1 for none."""


class Rolling(NamedTuple):
    """Direction in which a wheel rolls, shorter than 1 near standstill; its speed, and that smoothed; the direction's
    partials by the velocity of its place, `along` x and y; and by its heading, with the speed's."""

    x: float
    y: float
    speed: float
    norm: float
    along: tuple[tuple[float, float], tuple[float, float]]
    by_heading: tuple[float, float]
    speed_by_heading: float


@compiled
def drag(
    at: KernelSituation, own: EffectValues, wheel: int, coefficient: float, out: Parts
) -> tuple[float, float, float]:
    """Adds the drag of one wheel with partials by velocity, phi and heading; returns the wrench (3,) of a unit force
    along its rolling."""
    x, y, k = place_of(at, own, wheel)
    way = rolling(at, own, wheel)
    unit = (way.x, way.y, x * way.y - y * way.x)
    force = coefficient * at.loads[wheel]
    add_by_velocity(x, y, force, way.along, out)
    for i in range(3):
        out.value[i] -= force * unit[i]
        for j in range(4):
            out.by_phi[i, j] -= coefficient * unit[i] * at.carried[wheel, j]
    add_by_heading((x, y, k), force, way.by_heading, out)
    return unit


@compiled
def add_by_velocity(
    x: float, y: float, force: float, along: tuple[tuple[float, float], tuple[float, float]], out: Parts
) -> None:
    """Adds what a drag at (x, y) changes by with the cart's velocity: `force` (N) times the partials of its direction
    by the velocity there."""
    first, second = (1.0, 0.0, -y), (0.0, 1.0, x)
    (xx, xy), (yx, yy) = along
    for i in range(3):
        for j in range(3):
            slope = first[i] * (xx * first[j] + xy * second[j]) + second[i] * (yx * first[j] + yy * second[j])
            out.by_velocity[i, j] -= force * slope


@compiled
def add_by_heading(place: WheelPlace, force: float, turned: tuple[float, float], out: Parts) -> None:
    """Adds what a drag changes by with the wheel's heading: `force` (N) times the partials of its direction."""
    x, y, k = place
    if k >= 0:
        out.by_memory[0, k] -= force * turned[0]
        out.by_memory[1, k] -= force * turned[1]
        out.by_memory[2, k] -= force * (x * turned[1] - y * turned[0])


@compiled
def hold(at: KernelSituation, own: EffectValues, wheel: int, level: float, columns: Array) -> None:
    """Writes the wrenches that one wheel may give near standstill, of `level` (N): one along its heading, or two."""
    x, y, k = place_of(at, own, wheel)
    way = rolling(at, own, wheel)
    level *= 1.0 - way.x**2 - way.y**2
    if at.wheels[wheel, 2] == 1.0 and k < 0:
        hold_anywhere(x, y, level, columns[2 * wheel : 2 * wheel + 2])
        return
    cosine, sine = _heading(own, k)
    columns[2 * wheel, 0], columns[2 * wheel, 1] = cosine * level, sine * level
    columns[2 * wheel, 2] = (x * sine - y * cosine) * level


@compiled
def hold_anywhere(x: float, y: float, level: float, columns: Array) -> None:
    columns[0, 0], columns[0, 2] = level, -y * level
    columns[1, 1], columns[1, 2] = level, x * level


@compiled
def place_of(at: KernelSituation, own: EffectValues, wheel: int) -> WheelPlace:
    k = -1
    if at.wheels[wheel, 2] == 1.0 and len(own.memory) > 0:
        k = 0
        for other in range(wheel):
            if at.wheels[other, 2] == 1.0:
                k += 1
    return at.wheels[wheel, 0], at.wheels[wheel, 1], k


@compiled
def _heading(own: EffectValues, k: int) -> tuple[float, float]:
    """Cosine and sine of a wheel's heading in {b}."""
    return (math.cos(own.memory[k]), math.sin(own.memory[k])) if k >= 0 else (1.0, 0.0)


@compiled
def rolling(at: KernelSituation, own: EffectValues, wheel: int) -> Rolling:
    x, y, k = place_of(at, own, wheel)
    if at.wheels[wheel, 2] == 1.0 and k < 0:
        return rolling_anywhere(at, x, y)
    (along, across), (cosine, sine) = pivot_velocity(at, x, y), _heading(own, k)
    speed, slip = cosine * along + sine * across, cosine * across - sine * along
    norm = math.sqrt(speed**2 + at.smoothing_speed**2)
    sign, slope = speed / norm, at.smoothing_speed**2 / norm**3
    partials = ((slope * cosine * cosine, slope * cosine * sine), (slope * cosine * sine, slope * sine * sine))
    turned = (slope * slip * cosine - sign * sine, slope * slip * sine + sign * cosine)
    return Rolling(sign * cosine, sign * sine, speed, norm, partials, turned, slip)


@compiled
def rolling_anywhere(at: KernelSituation, x: float, y: float) -> Rolling:
    """How a wheel rolls that follows the velocity of its place at once."""
    along, across = pivot_velocity(at, x, y)
    norm = math.sqrt(along**2 + across**2 + at.smoothing_speed**2)
    unit_x, unit_y = along / norm, across / norm
    xy = -unit_x * unit_y / norm
    partials = (((1.0 - unit_x**2) / norm, xy), (xy, (1.0 - unit_y**2) / norm))
    return Rolling(unit_x, unit_y, math.sqrt(along**2 + across**2), norm, partials, (0.0, 0.0), 0.0)
