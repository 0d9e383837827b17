"""What swinging casters do to the balances: where they are listed, they may turn a cart more than its inertia does."""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.wheels import CASTER, DEFAULT_TRAIL, Wheel

SWINGING = 0.2
"""rad/s: over which swivel friction turns round."""


def caster_forces(cart: CartModel, time: Array, heading: Array, speeds: Array) -> Array:
    """Forward force and moment (n, 2) of all listed casters of a swivel torque of 1 N·m, at headings (n,) and speeds
    u, w, r (n, 3) of {b}, as `cartgrasp.effects.CasterRealignment` has them. They begin as they trail."""
    found = np.zeros((len(time), 2))
    for wheel in cart.wheels:
        if wheel.kind == CASTER:
            found += _of(wheel, time, heading, speeds)
    return found


def _of(wheel: Wheel, time: Array, heading: Array, speeds: Array) -> Array:
    u, w, r = speeds.T
    ahead, left = u - wheel.y * r, w + wheel.x * r
    trail = wheel.trail or DEFAULT_TRAIL
    course = np.arctan2(left, ahead) + heading
    swung = _headings(course, np.hypot(ahead, left) * np.diff(time, append=time[-1]) / trail)
    delta = swung - heading
    c, s = np.cos(delta), np.sin(delta)
    rate = (left * c - ahead * s) / trail - r
    force = -np.tanh(rate / SWINGING) / trail
    lever = (wheel.x - trail * c) * c + (wheel.y - trail * s) * s
    return np.column_stack([-force * s, force * lever])


def _headings(course: Array, travelled: Array) -> Array:
    """Headings in {s} (n,) of a wheel that trails a pivot on courses (n,), for way in trails (n,) on each: of the angle
    between both, tan(angle / 2) fades with exp(-way)."""
    found = np.empty(len(course))
    now = course[0]
    for i, (way, fade) in enumerate(zip(course.tolist(), np.exp(-travelled).tolist(), strict=True)):
        found[i] = now
        behind = math.remainder(now - way, math.tau)
        now = way + 2 * math.atan(math.tan(behind / 2) * fade)
    return found
