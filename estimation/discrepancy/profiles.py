"""How what passes may rise and fall: at once, as a model's effect does, or as somebody pushes, in half a sine.

A profile is a sum of effects that act at once, nested in time; with amplitudes that are linear, so are their slopes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cartgrasp.effects import Effect

LEVELS = 8
MEAN = 2 / np.pi
"""Of half a sine, over its height."""
WIDTH, BEFORE = 0.742, 0.129
"""Of half a sine's length: that of the rectangle which is nearest to it, and how much later that begins."""

Profile = Callable[[Effect], Sequence[tuple[float, Effect]]]
"""Shares of an effect's amplitudes, and when each acts."""


def at_once(effect: Effect) -> list[tuple[float, Effect]]:
    return [(1.0, effect)]


def half_sine(effect: Effect) -> list[tuple[float, Effect]]:
    """Of one that begins at its first value (s) and lasts for its second."""
    start, duration = effect.values[:2]
    found = []
    for height in (np.arange(LEVELS) + 0.5) / LEVELS:
        rises = float(np.arcsin(height)) / np.pi * duration
        found.append((1 / LEVELS, effect.with_values(np.r_[start + rises, duration - 2 * rises, effect.values[2:]])))
    return found


def around(effect: Effect) -> Effect:
    """Half a sine to which one that acts at once is nearest: when it begins, and how long it lasts."""
    start, duration = effect.values[:2]
    whole = duration / WIDTH
    return effect.with_values(np.r_[start - BEFORE * whole, whole, effect.values[2:]])
