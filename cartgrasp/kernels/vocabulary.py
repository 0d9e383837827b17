"""Which kernel a force or an inertia effect of the library has; no other effect has one.

A new one is a number, a row of `KINDS` and a branch wherever it has something to do."""

from __future__ import annotations

from cartgrasp.frames import Array

from . import (
    caster_realignment,
    directional_drag,
    end_stop,
    external_push,
    floor_patch,
    floor_slope,
    learned_force,
    load_slosh,
    payload_change,
    quadratic_drag,
    rolling_resistance,
    stribeck_friction,
    unknown_slope,
    viscous_drag,
    wheel_drag_imbalance,
)
from .casters import add_heading_rates, settle_headings
from .jit import compiled
from .situation import EffectValues, KernelSituation, Parts

VISCOUS_DRAG = 0
ROLLING_RESISTANCE = 1
STRIBECK_FRICTION = 2
QUADRATIC_DRAG = 3
DIRECTIONAL_DRAG = 4
FLOOR_SLOPE = 5
FLOOR_PATCH = 6
CASTER_REALIGNMENT = 7
WHEEL_DRAG_IMBALANCE = 8
EXTERNAL_PUSH = 9
PAYLOAD_CHANGE = 10
LOAD_SLOSH = 11
END_STOP = 12
LEARNED_FORCE = 13
UNKNOWN_SLOPE = 14

KINDS = {
    "viscous_drag": VISCOUS_DRAG,
    "rolling_resistance": ROLLING_RESISTANCE,
    "stribeck_friction": STRIBECK_FRICTION,
    "quadratic_drag": QUADRATIC_DRAG,
    "directional_drag": DIRECTIONAL_DRAG,
    "floor_slope": FLOOR_SLOPE,
    "floor_patch": FLOOR_PATCH,
    "caster_realignment": CASTER_REALIGNMENT,
    "wheel_drag_imbalance": WHEEL_DRAG_IMBALANCE,
    "external_push": EXTERNAL_PUSH,
    "payload_change": PAYLOAD_CHANGE,
    "load_slosh": LOAD_SLOSH,
    "end_stop": END_STOP,
    "learned_force": LEARNED_FORCE,
    "unknown_slope": UNKNOWN_SLOPE,
}


STICTION_EFFECTS = frozenset(
    {
        "rolling_resistance",
        "stribeck_friction",
        "floor_patch",
        "caster_realignment",
        "wheel_drag_imbalance",
        "learned_force",
    }
)
"""Those with a branch in `add_stiction`."""


@compiled
def add_phi_change(kind: int, time: float, own: EffectValues, phi: Array, by_own: Array) -> None:
    if kind == PAYLOAD_CHANGE:
        payload_change.phi_change(time, own, phi, by_own)


@compiled
def add_wrench(kind: int, at: KernelSituation, own: EffectValues, out: Parts) -> None:
    if kind == VISCOUS_DRAG:
        viscous_drag.wrench(at, own, out)
    elif kind == ROLLING_RESISTANCE:
        rolling_resistance.wrench(at, own, out)
    elif kind == STRIBECK_FRICTION:
        stribeck_friction.wrench(at, own, out)
    elif kind == QUADRATIC_DRAG:
        quadratic_drag.wrench(at, own, out)
    elif kind == DIRECTIONAL_DRAG:
        directional_drag.wrench(at, own, out)
    elif kind == FLOOR_SLOPE:
        floor_slope.wrench(at, own, out)
    elif kind == FLOOR_PATCH:
        floor_patch.wrench(at, own, out)
    elif kind == CASTER_REALIGNMENT:
        caster_realignment.wrench(at, own, out)
    elif kind == WHEEL_DRAG_IMBALANCE:
        wheel_drag_imbalance.wrench(at, own, out)
    elif kind == EXTERNAL_PUSH:
        external_push.wrench(at, own, out)
    elif kind == LOAD_SLOSH:
        load_slosh.wrench(at, own, out)
    elif kind == END_STOP:
        end_stop.wrench(at, own, out)
    elif kind == LEARNED_FORCE:
        learned_force.wrench(at, own, out)
    elif kind == UNKNOWN_SLOPE:
        unknown_slope.wrench(at, own, out)


@compiled
def add_memory_rate(kind: int, at: KernelSituation, own: EffectValues, out: Parts) -> None:
    if kind in (ROLLING_RESISTANCE, STRIBECK_FRICTION, FLOOR_PATCH):
        add_heading_rates(at, own.memory, out)
    elif kind == CASTER_REALIGNMENT:
        caster_realignment.memory_rate(at, own, out)
    elif kind == LOAD_SLOSH:
        load_slosh.memory_rate(at, own, out)
    elif kind == LEARNED_FORCE:
        learned_force.memory_rate(at, own, out)


@compiled
def add_stiction(kind: int, at: KernelSituation, own: EffectValues, columns: Array) -> int:
    if kind == ROLLING_RESISTANCE:
        return rolling_resistance.stiction(at, own, columns)
    if kind == STRIBECK_FRICTION:
        return stribeck_friction.stiction(at, own, columns)
    if kind == FLOOR_PATCH:
        return floor_patch.stiction(at, own, columns)
    if kind == CASTER_REALIGNMENT:
        return caster_realignment.stiction(at, own, columns)
    if kind == WHEEL_DRAG_IMBALANCE:
        return wheel_drag_imbalance.stiction(at, own, columns)
    if kind == LEARNED_FORCE:
        return learned_force.stiction(at, own, columns)
    return 0


@compiled
def settle(kind: int, at: KernelSituation, own: EffectValues, memory: Array) -> None:
    if kind in (ROLLING_RESISTANCE, STRIBECK_FRICTION, FLOOR_PATCH):
        settle_headings(at, own.memory, memory)
    elif kind == CASTER_REALIGNMENT:
        caster_realignment.settled(at, own, memory)
    elif kind == LOAD_SLOSH:
        load_slosh.settled(at, own, memory)
