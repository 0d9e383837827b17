"""Smooth signs and steps."""

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
