"""How casters swing (physics.md): a caster at pivot p trails its wheel by b at a heading delta in {b}, and

delta' = (v_p · n) / b - r,    n = (-sin delta, cos delta),    v_p = (u - y r, w + x r).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cartgrasp.frames import Array

from .jit import compiled
from .situation import EffectValues, KernelSituation, Parts


class Caster(NamedTuple):
    """A pivot's place in {b}, the trail (m), and the heading (rad)."""

    x: float
    y: float
    trail: float
    heading: float


@compiled
def listed(at: KernelSituation, k: int, heading: float) -> Caster:
    """The k-th caster as the cart's wheels list it."""
    return Caster(at.pivots[k, 0], at.pivots[k, 1], at.pivots[k, 2], heading)


@compiled
def heading_rates(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    """Adds the rates of all listed casters' headings, with partials by velocity and heading: the `memory_rate` of what
    each wheel does along its heading."""
    for k in range(len(own.memory)):
        rate, by_velocity, by_heading = heading_rate(at, listed(at, k, own.memory[k]))
        out.value[k] += rate
        for j in range(3):
            out.by_velocity[k, j] += by_velocity[j]
        out.by_memory[k, k] += by_heading


@compiled
def settled_headings(at: KernelSituation, own: EffectValues, memory: Array) -> None:
    """Writes where all listed casters come to rest: `settled`, of the same effects."""
    for k in range(len(own.memory)):
        memory[k] = settled_heading(at, listed(at, k, own.memory[k]))


@compiled
def heading_rate(at: KernelSituation, caster: Caster) -> tuple[float, tuple[float, float, float], float]:
    """delta', and its partials by velocity and delta."""
    sine, cosine = math.sin(caster.heading), math.cos(caster.heading)
    along, across = pivot_velocity(at, caster.x, caster.y)
    by_velocity = (
        -sine / caster.trail,
        cosine / caster.trail,
        (sine * caster.y + cosine * caster.x) / caster.trail - 1.0,
    )
    by_heading = -(cosine * along + sine * across) / caster.trail
    return (cosine * across - sine * along) / caster.trail - at.velocity[2], by_velocity, by_heading


@compiled
def pivot_velocity(at: KernelSituation, x: float, y: float) -> tuple[float, float]:
    u, w, r = at.velocity[0], at.velocity[1], at.velocity[2]
    return u - y * r, w + x * r


@compiled
def settled_heading(at: KernelSituation, caster: Caster) -> float:
    """Where a caster comes to rest, at the turn nearest to its heading: it trails its pivot, but for as much as
    delta' = 0 asks in a turn."""
    along, across = pivot_velocity(at, caster.x, caster.y)
    held_back = caster.trail * at.velocity[2] / max(math.hypot(along, across), 1e-9)
    turn = math.atan2(across, along) - math.asin(min(max(held_back, -1.0), 1.0)) - caster.heading
    return caster.heading + turn - 2.0 * math.pi * math.floor((turn + math.pi) / (2.0 * math.pi))
