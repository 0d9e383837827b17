"""Between the free directions of a cart, its body {b}, and the world {s}."""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from .jit import compiled


@compiled
def to_free(project: Array, heading: float, found: Array) -> None:
    """What takes a velocity in {s} to nu (k, 3), where `project` (k, 3) takes one in {b} to it."""
    cosine, sine = math.cos(heading), math.sin(heading)
    for a in range(len(project)):
        found[a, 0] = project[a, 0] * cosine - project[a, 1] * sine
        found[a, 1] = project[a, 0] * sine + project[a, 1] * cosine
        found[a, 2] = project[a, 2]


@compiled
def raised(lift: Array, reduced: Array, push: Array) -> None:
    """The wrench in {b} (3,) of a reduced one (k,); `lift` (3, k)."""
    for j in range(3):
        push[j] = 0.0
        for a in range(len(reduced)):
            push[j] += lift[j, a] * reduced[a]


@compiled
def add_creep(direction: tuple[float, float], creep: Array, share: float, noise: Array) -> None:
    """Adds to the noise of a position so many times that of creeping along `creep` (2,) of {b}; `direction`: cosine and
    sine of the heading."""
    cosine, sine = direction
    sideways = (cosine * creep[0] - sine * creep[1], sine * creep[0] + cosine * creep[1])
    for i in range(2):
        for j in range(2):
            noise[i, j] += share * sideways[i] * sideways[j]
