"""`effects/end_stop.py`: parameters position, side, restitution, stiffness, damping; the constant is
`SMOOTHING_DEPTH`."""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from ..jit import compiled
from ..situation import EffectValues, KernelSituation, Parts
from ..smooth import smooth_step


@compiled
def wrench(at: KernelSituation, own: EffectValues, out: Parts) -> None:
    side, cosine, sine = own.parameters[1], math.cos(at.pose[2]), math.sin(at.pose[2])
    along, across = at.pose[0] - own.parameters[0], sine * at.velocity[0] + cosine * at.velocity[1]
    speed = cosine * at.velocity[0] - sine * at.velocity[1]
    push, by_depth, by_rate, by_stiffness, by_damping = _push(side * along, side * speed, own)
    _add(-side * push, cosine, sine, out.value)
    if push == 0.0:
        return
    _add(-side * side * by_depth, cosine, sine, out.by_pose[:, 0])
    _add(side * side * by_rate * across, cosine, sine, out.by_pose[:, 2])
    _add(-side * push, -sine, cosine, out.by_pose[:, 2])
    _add(-side * side * by_rate * cosine, cosine, sine, out.by_velocity[:, 0])
    _add(side * side * by_rate * sine, cosine, sine, out.by_velocity[:, 1])
    _add(side * side * by_depth, cosine, sine, out.by_parameters[:, 0])
    _add(-push - side * (by_depth * along + by_rate * speed), cosine, sine, out.by_parameters[:, 1])
    _add(-side * by_stiffness, cosine, sine, out.by_parameters[:, 3])
    _add(-side * by_damping, cosine, sine, out.by_parameters[:, 4])


@compiled
def _push(depth: float, rate: float, own: EffectValues) -> tuple[float, float, float, float, float]:
    """The force (N) against the cart, and its partials by depth, its rate, stiffness and damping."""
    stiffness, damping, width = own.parameters[3], own.parameters[4], own.constants[0]
    touch, touching = smooth_step(depth, width)
    if touch == 0.0 or (stiffness == 0.0 and damping == 0.0):
        return 0.0, 0.0, 0.0, 0.0, 0.0
    pressed = max(depth, 0.0) + 0.5 * width * math.log1p(math.exp(-2.0 * abs(depth) / width))
    raw, rounding = stiffness * pressed + damping * rate, stiffness * width
    root = math.sqrt(raw * raw + rounding * rounding)
    if root == 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0
    kept = 0.5 * (raw + root)
    by_raw = touch * kept / root
    by_stiffness = by_raw * pressed + touch * width * rounding / (2.0 * root)
    return touch * kept, touching * kept + by_raw * stiffness * touch, by_raw * damping, by_stiffness, by_raw * rate


@compiled
def _add(force: float, cosine: float, sine: float, wrench: Array) -> None:
    """A force along the world's x, at {b}'s origin."""
    wrench[0] += force * cosine
    wrench[1] -= force * sine
