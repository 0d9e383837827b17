"""Smooth signs, steps and ramps."""

from __future__ import annotations

import math

from .jit import compiled


@compiled
def smooth_sign(speed: float, width: float) -> tuple[float, float]:
    """The sign of `speed`, 0 at 0, and its derivative."""
    norm = math.sqrt(speed * speed + width * width)
    return speed / norm, width * width / norm**3


@compiled
def smooth_step(distance: float, width: float) -> tuple[float, float]:
    """A step from 0 to 1 where `distance` passes 0, and its derivative; it rises over `2 width`."""
    tanh = math.tanh(distance / width)
    return (1.0 + tanh) / 2.0, (1.0 - tanh * tanh) / (2.0 * width)


@compiled
def smooth_ramp(distance: float, width: float) -> tuple[float, float]:
    """`max(distance, 0)` averaged over `width` to either side with the weight 3 (1 - t²) / 4, and its derivative."""
    t = distance / width
    if t <= -1.0:
        return 0.0, 0.0
    if t >= 1.0:
        return distance, 1.0
    return width * (0.1875 + t * (0.5 + t * (0.375 - 0.0625 * t * t))), 0.5 + t * (0.75 - 0.25 * t * t)
