"""Pushes that rise and fall: a rectangle that is nearest to half a sine begins later and ends earlier than it."""

from __future__ import annotations

import numpy as np

from cartgrasp.effects import Effect
from cartgrasp.frames import Array

from ..search.screening import Screen

HALF_SINE_LEAD_FRACTION = 0.174
"""Share of a rectangle's duration, on each side, by which the half sine is longer to which it is the nearest. That has
most of sin(a)/√a within ±a of its middle, where tan(a) = 2a."""


def half_sine_gain(screen: Screen, effect: Effect) -> float:
    """Gain of half a sine over the span of an effect that begins and ends."""
    start, duration = effect.values[:2].tolist()

    def share(time: Array) -> Array:
        return np.asarray(np.sin(np.pi * np.clip((time - start) / duration, 0.0, 1.0)))

    return screen.gain(effect, share)


def as_half_sine(effect: Effect) -> Effect:
    """The effect over the span of the half sine to which its rectangle is the nearest."""
    values = effect.values.copy()
    values[0] -= HALF_SINE_LEAD_FRACTION * effect.values[1]
    values[1] *= 1 + 2 * HALF_SINE_LEAD_FRACTION
    return effect.with_values(values)


def with_impulse_of(effect: Effect, span: Effect) -> Effect:
    """The effect over another's span, with the impulse of the first."""
    values = effect.values.copy()
    values[2:] *= effect.values[1] / span.values[1]
    values[:2] = span.values[:2]
    return effect.with_values(values)
