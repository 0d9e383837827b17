"""Forces that the vocabulary has no name for, at {b}'s origin: a kind each, with a size and two numbers of its own."""

from __future__ import annotations

import math

from .compiling import compiled
from .world import THETA, WAY, R, U, X, Y

PULSES, HUM, BENT_WHEEL, TETHER, WARMING, GRAIN, CUBIC_DRAG, SCRUB, RIDGES, AXLE_DRAG, DRIFT, ROUGH_SIDE = (
    float(k) for k in range(1, 13)
)
DRY = 0.008
"""m/s, of tanh."""
PULSE = 0.2
"""Of a period."""


@compiled
def foreign_wrench(time, state, world):
    """Forward force, sideways force and yaw moment in {b}."""
    kind, size, a, b = world.law, world.law_size, world.law_a, world.law_b
    u, r, heading = state[U], state[R], state[THETA]
    dry = math.tanh(u / DRY)
    if kind == PULSES:
        phase = (time / a + b) % 1.0
        return (size * math.sin(math.pi * phase / PULSE) if phase < PULSE else 0.0), 0.0, 0.0
    if kind == HUM:
        turn = 2.0 * math.pi * (time / a + b)
        return size * (math.sin(turn) + 0.3 * math.sin(2.0 * turn + 1.0)), 0.0, 0.0
    if kind == BENT_WHEEL:
        return 0.0, 0.0, size * math.sin(2.0 * math.pi * (state[WAY] / a + b))
    if kind == TETHER:
        fx, fy = -size * (state[X] - a), -size * (state[Y] - b)
        return in_body(fx, fy, heading)
    if kind == WARMING:
        return -size * math.exp(-time / a) * u, 0.0, 0.0
    if kind == GRAIN:
        return -size * math.cos(2.0 * (heading - a)) * dry, 0.0, 0.0
    if kind == CUBIC_DRAG:
        return -size * u * u * u, 0.0, 0.0
    if kind == SCRUB:
        return -size * abs(r) * dry, 0.0, 0.0
    if kind == RIDGES:
        return in_body(size * math.sin(2.0 * math.pi * (state[X] / a + b)), 0.0, heading)
    if kind == AXLE_DRAG:
        return -size * dry, 0.0, 0.0
    if kind == DRIFT:
        return size * time / a, 0.0, 0.0
    if kind == ROUGH_SIDE:
        return -size * (0.5 + 0.5 * math.tanh((state[X] - a) / b)) * dry, 0.0, 0.0
    return 0.0, 0.0, 0.0


@compiled
def in_body(fx, fy, heading):
    cosine, sine = math.cos(heading), math.sin(heading)
    return cosine * fx + sine * fy, cosine * fy - sine * fx, 0.0
