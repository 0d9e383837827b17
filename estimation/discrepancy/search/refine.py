"""Settings that enter nonlinearly (onsets, places, frequencies, delays) by pattern search around the best of a grid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cartgrasp.effects import Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.effects.time_delay import TimeDelay
from cartgrasp.frames import Array

from .candidates import amplitudes_of
from .plausibility import BOUND_SLACK_RATIO, out_of_bounds

MAX_STEP_HALVINGS, MAX_GAIN_EVALUATIONS = 8, 160
FIRST_TIME_STEP, FIRST_PLACE_STEP, FIRST_DELAY_STEP = 0.4, 0.8, 0.01
FIRST_STEP_RATIO = 1.6


@dataclass(frozen=True)
class Move:
    """Change of one setting, by a step or (0) by a factor; `against` moves the other way, to keep an end."""

    which: int
    step: float
    against: int | None = None
    beside: int | None = None

    def applied(self, values: Array, share: float) -> Array:
        moved = values.copy()
        if self.step:
            moved[self.which] += share * self.step
        else:
            moved[self.which] *= FIRST_STEP_RATIO**share
        if self.against is not None:
            moved[self.against] -= share * self.step
        if self.beside is not None:
            moved[self.beside] *= moved[self.which] / values[self.which]
        return moved


def moves(effect: Effect) -> list[Move]:
    if isinstance(effect, TimeDelay):
        return [Move(0, FIRST_DELAY_STEP)]
    if effect.gate is Gate.FROM:
        return [Move(0, FIRST_TIME_STEP)]
    if effect.gate is Gate.WHILE:
        return [Move(0, FIRST_TIME_STEP, against=1), Move(1, FIRST_TIME_STEP), Move(0, FIRST_TIME_STEP)]
    if effect.gate is Gate.INSIDE:
        return [Move(i, FIRST_PLACE_STEP) for i in range(4)]
    own = set(amplitudes_of(effect).tolist())
    found = [
        Move(i, 0.0)
        for i, p in enumerate(effect.parameters)
        if i not in own and not p.estimated and effect.values[i] > 0
    ]
    lengths = [m.which for m in found if effect.parameters[m.which].unit == "m"]
    return found + [Move(one, 0.0, beside=other) for one, other in pairwise(lengths)]


def refined(effect: Effect, gain: Callable[[Effect], float]) -> Effect:
    """The effect where the gain is largest nearby."""
    steps, best, left = moves(effect), gain(effect), MAX_GAIN_EVALUATIONS
    for halving in range(MAX_STEP_HALVINGS if steps else 0):
        improved = True
        while improved and left > 0:
            improved = False
            for move in steps:
                for sign in (1.0, -1.0):
                    values = move.applied(effect.values, sign / 2**halving)
                    if not is_open(effect, values) or out_of_bounds(effect.with_values(values), BOUND_SLACK_RATIO):
                        continue
                    left -= 1
                    tried = effect.with_values(values)
                    found = gain(tried)
                    if found > best + 1e-9:
                        effect, best, improved = tried, found, True
                        break
    return effect


def is_open(effect: Effect, values: Array) -> bool:
    low = np.array([p.lower for p in effect.parameters])
    high = np.array([p.upper for p in effect.parameters])
    if (values < low).any() or (values > high).any():
        return False
    if effect.gate is Gate.WHILE:
        return bool(values[1] > 0.02)
    if effect.gate is Gate.INSIDE:
        return bool(values[1] > values[0] + 0.05 and values[3] > values[2] + 0.05)
    return True
