"""How what passes may rise and fall: at once, as a model's effect does, or as somebody pushes, in half a sine.

A profile is a sum of effects that act at once, nested in time; with amplitudes that are linear, so are their slopes.
Smoothed motion smears what begins at once over a tenth of a second or two.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cartgrasp.effects import Effect

LEVELS, EDGES = 8, 4
MOST_EDGE = 0.9
"""Of what is smeared: how long its edges are at most."""
MEAN = 2 / np.pi
"""Of half a sine, over its height."""
WIDTH, BEFORE = 0.742, 0.129
"""Of half a sine's length: that of the rectangle which is nearest to it, and how much later that begins."""

Profile = Callable[[Effect], Sequence[tuple[float, Effect]]]
"""Shares of an effect's amplitudes, and when each acts."""


def at_once(effect: Effect) -> list[tuple[float, Effect]]:
    return [(1.0, effect)]


def smeared(width: float) -> Profile:
    """Of one that begins and ends in the middle of edges which take `width` (s)."""

    def profile(effect: Effect) -> list[tuple[float, Effect]]:
        edge = min(width, MOST_EDGE * float(effect.values[1]))
        return [(1 / EDGES, _trimmed(effect, edge * share)) for share in (np.arange(EDGES) + 0.5) / EDGES - 0.5]

    return profile


def half_sine(effect: Effect) -> list[tuple[float, Effect]]:
    """Of one that begins at its first value (s) and lasts for its second."""
    rises = np.arcsin((np.arange(LEVELS) + 0.5) / LEVELS) / np.pi * effect.values[1]
    return [(1 / LEVELS, _trimmed(effect, rise)) for rise in rises]


def _trimmed(effect: Effect, by: float) -> Effect:
    """Begins later, and ends earlier (s)."""
    start, duration = effect.values[:2]
    return effect.with_values(np.r_[start + by, duration - 2 * by, effect.values[2:]])


def around(effect: Effect) -> Effect:
    """Half a sine to which one that acts at once is nearest: when it begins, and how long it lasts."""
    start, duration = effect.values[:2]
    whole = duration / WIDTH
    return effect.with_values(np.r_[start - BEFORE * whole, whole, effect.values[2:]])
