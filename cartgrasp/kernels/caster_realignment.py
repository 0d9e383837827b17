"""`effects/caster_realignment.py`: parameters swivel_torque, trail, x; a heading a pivot; the constant is
`SMOOTHING_RATE`."""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from .casters import Caster, heading_rate, settled_heading
from .jit import compiled
from .situation import Own, Parts, Situation
from .smooth import smooth_sign


@compiled
def wrench(at: Situation, own: Own, out: Parts) -> None:
    torque, has_trail = own.parameters[0], own.parameters[1] > 0.0
    for k in range(len(own.memory)):
        trail = _caster(at, own, k).trail
        rate, by_velocity, by_heading, by_trail, by_x = _swivel(at, own, k)
        slip, slope = smooth_sign(rate, own.constants[0])
        strength = -torque / trail * slip
        by_rate = -torque / trail * slope
        side, turned = _side(at, own, k)
        for i in range(3):
            out.value[i] += strength * side[i]
            for j in range(3):
                out.by_velocity[i, j] += by_rate * by_velocity[j] * side[i]
            out.by_memory[i, k] += by_rate * by_heading * side[i] + strength * turned[i]
            out.by_parameters[i, 0] -= slip / trail * side[i]
            if has_trail:
                out.by_parameters[i, 1] += (by_rate * by_trail - strength / trail) * side[i]
            out.by_parameters[i, 2] += by_rate * by_x * side[i]
        if has_trail:
            out.by_parameters[2, 1] -= strength
        out.by_parameters[2, 2] += strength * side[1]


@compiled
def memory_rate(at: Situation, own: Own, out: Parts) -> None:
    for k in range(len(own.memory)):
        rate, by_velocity, by_heading, by_trail, by_x = _swivel(at, own, k)
        out.value[k] += rate
        for j in range(3):
            out.by_velocity[k, j] += by_velocity[j]
        out.by_memory[k, k] += by_heading
        if own.parameters[1] > 0.0:
            out.by_parameters[k, 1] += by_trail
        out.by_parameters[k, 2] += by_x


@compiled
def stiction(at: Situation, own: Own, columns: Array) -> int:
    for k in range(len(own.memory)):
        trail, rate = _caster(at, own, k).trail, _swivel(at, own, k)[0]
        slip, _ = smooth_sign(rate, own.constants[0])
        side, _ = _side(at, own, k)
        for i in range(3):
            columns[k, i] = own.parameters[0] / trail * (1.0 - slip * slip) * side[i]
    return len(own.memory)


@compiled
def settled(at: Situation, own: Own, memory: Array) -> None:
    """Each caster trails its pivot, at the turn nearest to the heading."""
    for k in range(len(own.memory)):
        memory[k] = settled_heading(at, _caster(at, own, k))


@compiled
def _caster(at: Situation, own: Own, k: int) -> Caster:
    trail = own.parameters[1] if own.parameters[1] > 0.0 else at.pivots[k, 2]
    return Caster(at.pivots[k, 0] + own.parameters[2], at.pivots[k, 1], trail, own.memory[k])


@compiled
def _swivel(at: Situation, own: Own, k: int) -> tuple[float, tuple[float, float, float], float, float, float]:
    """delta', and its partials by velocity, delta, the trail and x."""
    caster = _caster(at, own, k)
    rate, by_velocity, by_heading = heading_rate(at, caster)
    turning = at.velocity[2]
    by_x = turning * math.cos(caster.heading) / caster.trail
    return rate, by_velocity, by_heading, -(rate + turning) / caster.trail, by_x


@compiled
def _side(at: Situation, own: Own, k: int) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Wrench of a unit side force at the patch, and its partial by heading. The force is across the trail, so the
    trail enters the moment whole."""
    caster = _caster(at, own, k)
    sine, cosine = math.sin(caster.heading), math.cos(caster.heading)
    side = (-sine, cosine, caster.x * cosine + caster.y * sine - caster.trail)
    return side, (-cosine, -sine, caster.y * cosine - caster.x * sine)
