"""`effects/caster_realignment.py`: parameters swivel_torque, trail, x, scrub_torque, smoothing_rate; a heading
a pivot."""

from __future__ import annotations

import math
from typing import NamedTuple

from cartgrasp.frames import Array

from ..casters import Caster, heading_rate, settled_heading
from ..jit import compiled
from ..situation import EffectValues, KernelSituation, Parts
from ..smooth import smooth_sign


class Turning(NamedTuple):
    """A caster's turning rate, rad/s, and its partials by velocity, heading, the trail and x."""

    rate: float
    by_velocity: tuple[float, float, float]
    by_heading: float
    by_trail: float
    by_x: float


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    for k in range(len(own.memory)):
        swivel = _swivel(at, own, k)
        _add_friction(at, own, k, 0, swivel, out)
        _add_friction(at, own, k, 3, _on_floor(at, swivel), out)


@compiled
def _add_friction(at: KernelSituation, own: EffectValues, k: int, which: int, turning: Turning, out: Parts) -> None:
    """Adds the wrench of the k-th caster's friction against `turning`, of which the torque is parameter number `which`.
    Of the swivel's, a force at the patch; of the tyre's, which the floor turns, too, at the pivot."""
    torque, has_trail, trail = own.parameters[which], own.parameters[1] > 0.0, _caster(at, own, k).trail
    slip, slope = smooth_sign(turning.rate, own.parameters[4])
    strength, by_rate = -torque / trail * slip, -torque / trail * slope
    side, turned = _side(at, own, k, trail if which == 0 else 0.0)
    for i in range(3):
        out.value[i] += strength * side[i]
        for j in range(3):
            out.by_velocity[i, j] += by_rate * turning.by_velocity[j] * side[i]
        out.by_memory[i, k] += by_rate * turning.by_heading * side[i] + strength * turned[i]
        out.by_parameters[i, which] -= slip / trail * side[i]
        out.by_parameters[i, 4] -= by_rate * turning.rate / own.parameters[4] * side[i]
        if has_trail:
            out.by_parameters[i, 1] += (by_rate * turning.by_trail - strength / trail) * side[i]
        out.by_parameters[i, 2] += by_rate * turning.by_x * side[i]
    if has_trail and which == 0:
        out.by_parameters[2, 1] -= strength
    out.by_parameters[2, 2] += strength * side[1]


@compiled
def memory_rate(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    for k in range(len(own.memory)):
        swivel = _swivel(at, own, k)
        out.value[k] += swivel.rate
        for j in range(3):
            out.by_velocity[k, j] += swivel.by_velocity[j]
        out.by_memory[k, k] += swivel.by_heading
        if own.parameters[1] > 0.0:
            out.by_parameters[k, 1] += swivel.by_trail
        out.by_parameters[k, 2] += swivel.by_x


@compiled
def stiction(at: KernelSituation, own: EffectValues, columns: Array) -> int:
    n = len(own.memory)
    for k in range(n):
        swivel = _swivel(at, own, k)
        _stick(at, own, k, 0, swivel, columns[k])
        _stick(at, own, k, 3, _on_floor(at, swivel), columns[n + k])
    return 2 * n


@compiled
def _stick(at: KernelSituation, own: EffectValues, k: int, which: int, turning: Turning, column: Array) -> None:
    trail = _caster(at, own, k).trail
    slip, _ = smooth_sign(turning.rate, own.parameters[4])
    side, _ = _side(at, own, k, trail if which == 0 else 0.0)
    for i in range(3):
        column[i] = own.parameters[which] / trail * (1.0 - slip * slip) * side[i]


@compiled
def settled(at: KernelSituation, own: EffectValues, memory: Array) -> None:
    """Each caster trails its pivot, at the turn nearest to the heading."""
    for k in range(len(own.memory)):
        memory[k] = settled_heading(at, _caster(at, own, k))


@compiled
def _caster(at: KernelSituation, own: EffectValues, k: int) -> Caster:
    trail = own.parameters[1] if own.parameters[1] > 0.0 else at.pivots[k, 2]
    return Caster(at.pivots[k, 0] + own.parameters[2], at.pivots[k, 1], trail, own.memory[k])


@compiled
def _swivel(at: KernelSituation, own: EffectValues, k: int) -> Turning:
    """delta' of the k-th caster."""
    caster = _caster(at, own, k)
    rate, by_velocity, by_heading = heading_rate(at, caster)
    by_x = at.velocity[2] * math.cos(caster.heading) / caster.trail
    return Turning(rate, by_velocity, by_heading, -(rate + at.velocity[2]) / caster.trail, by_x)


@compiled
def _on_floor(at: KernelSituation, swivel: Turning) -> Turning:
    """r + delta', at which a caster turns on the floor, from delta'."""
    ahead, across, turned = swivel.by_velocity
    by_velocity = (ahead, across, turned + 1.0)
    return Turning(swivel.rate + at.velocity[2], by_velocity, swivel.by_heading, swivel.by_trail, swivel.by_x)


@compiled
def _side(
    at: KernelSituation, own: EffectValues, k: int, behind: float
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Wrench of a unit side force so far (m) behind the pivot, and its partial by heading. The force is across the
    trail, so that distance enters the moment whole."""
    caster = _caster(at, own, k)
    sine, cosine = math.sin(caster.heading), math.cos(caster.heading)
    side = (-sine, cosine, caster.x * cosine + caster.y * sine - behind)
    return side, (-cosine, -sine, caster.y * cosine - caster.x * sine)
