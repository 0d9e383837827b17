"""Where, when and how fast exactly: the settings of an effect that no linear fit gives, by pattern search.

Each setting is judged by the most that the effect's amplitudes gain there, with the base's parameters free.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from copy import copy
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cartgrasp.effects import Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.frames import Array
from cartgrasp.wheels import WheelSet

from .dictionary import BLOCK, CELL, amplitudes_of, slopes_of
from .fitted import Fitted
from .profiles import Profile, at_once

HALVINGS = 5
EVALUATIONS = 60
FACTOR = 1.6
"""By which a speed or a frequency is first moved."""


@dataclass(frozen=True)
class Gain:
    """Half the chi-squared that the amplitudes take away, and their values."""

    value: float
    amplitudes: Array


class Refiner:
    """Around one fit."""

    def __init__(self, fitted: Fitted, implausible: Callable[[Effect], object] | None = None) -> None:
        """`implausible` says of an effect at a setting why it can't be, where it can't."""
        self._fitted, self._implausible = fitted, implausible or (lambda effect: False)
        self._profile: Profile = at_once
        information, self._pull = fitted.loose.information, fitted.loose.pull
        for (_, line, _), known in zip(fitted.linearised, fitted.loose_columns, strict=True):
            taught, drawn = line.taught(known)
            information, self._pull = information + taught, self._pull + drawn
        self._covariance = np.linalg.inv(information)

    def shaped(self, profile: Profile) -> Refiner:
        """The same, of what rises and falls otherwise."""
        other = copy(self)
        other._profile = profile
        return other

    def gain(self, effect: Effect, amplitudes: np.ndarray, std: Array) -> Gain:
        """Of amplitudes with prior standard deviations, added to the absent effect at a setting."""
        information, pull = np.diag(std**-2.0), np.zeros(len(std))
        to_base = np.zeros((len(std), len(self._pull)))
        for (regression, line, delay), known in zip(self._fitted.linearised, self._fitted.loose_columns, strict=True):
            shares, parts = zip(*self._profile(effect), strict=True)
            slopes = slopes_of(regression, parts, delay)
            columns = np.sum([share * own[..., amplitudes] for share, own in zip(shares, slopes, strict=True)], axis=0)
            whitened = line.whitened(columns)
            information, to_base = information + _product(whitened, columns), to_base + _product(whitened, known)
            pull = pull + _product(whitened, line.residual[..., None])[:, 0]
        through = to_base @ self._covariance
        information, pull = information - through @ to_base.T, pull - through @ self._pull
        best = np.linalg.solve(information, pull)
        return Gain(0.5 * float(pull @ best), np.asarray(best))

    def refined(self, effect: Effect, amplitudes: np.ndarray, std: Array) -> tuple[Effect, Gain]:
        """From an effect whose amplitudes have values."""
        effect, steps = absent(effect, amplitudes), moves(effect, amplitudes, self._fitted.cart.wheel_set)
        values, best = effect.values, self.gain(effect, amplitudes, std)
        left = EVALUATIONS
        for halving in range(HALVINGS if steps else 0):
            improved = True
            while improved and left > 0:
                improved = False
                for move in steps:
                    for sign in (1.0, -1.0):
                        tried = move.applied(values, sign / 2**halving)
                        if tried is None or not is_open(effect, tried):
                            continue
                        if self._implausible(effect.with_values(tried)):
                            continue
                        left -= 1
                        found = self.gain(effect.with_values(tried), amplitudes, std)
                        if found.value > best.value:
                            values, best, improved = effect.with_values(tried).values.copy(), found, True
                            break
        values = values.copy()
        values[amplitudes] += best.amplitudes
        return effect.with_values(values), best


def searched_again(
    fitted: Fitted, effects: Iterable[Effect], implausible: Callable[[Effect], object] | None = None
) -> Fitted:
    """With the settings of effects that were added, which were searched for without later ones, where they are best
    now."""
    for effect in effects:
        amplitudes = amplitudes_of(effect)
        searched = moves(effect, amplitudes, fitted.cart.wheel_set)
        if any(not effect.parameters[move.which].estimated for move in searched):
            known = next(one for one in fitted.cart.effects if one.key == effect.key)
            refiner = Refiner(fitted.without(effect.key), implausible)
            fitted = fitted.with_changed(effect, refiner.refined(known, amplitudes, prior_std(effect, amplitudes))[0])
    return fitted


def absent(effect: Effect, amplitudes: np.ndarray) -> Effect:
    """At the same setting, without its amplitudes."""
    values = effect.values.copy()
    values[amplitudes] = [effect.parameters[i].absent for i in amplitudes]
    return effect.with_values(values)


def prior_std(effect: Effect, amplitudes: np.ndarray) -> Array:
    return np.array([2 * effect.parameters[i].typical for i in amplitudes])


@dataclass(frozen=True)
class Move:
    """Of one parameter: by a step, or by a power of `FACTOR`; with another that moves the other way, to keep an end, or
    by the same factor."""

    which: int
    step: float
    against: int | None = None
    beside: int | None = None

    def applied(self, values: Array, share: float) -> Array | None:
        moved = values.copy()
        if self.step == 0.0:
            moved[self.which] *= FACTOR**share
        else:
            moved[self.which] += share * self.step
        if self.against is not None:
            moved[self.against] -= share * self.step
            if moved[self.against] <= 0:
                return None
        if self.beside is not None:
            moved[self.beside] *= moved[self.which] / values[self.which]
        return moved


def moves(effect: Effect, amplitudes: np.ndarray, wheels: WheelSet) -> list[Move]:
    if effect.gate is Gate.FROM:
        gate = [Move(0, BLOCK)]
    elif effect.gate is Gate.WHILE:
        gate = [Move(0, BLOCK, against=1), Move(1, BLOCK)]
    elif effect.gate is Gate.INSIDE:
        gate = [Move(i, CELL / 2) for i in range(4)]
    else:
        gate = []
    rest = [
        Move(i, 0.0 if effect.values[i] > 0 else parameter.typical)
        for i, (parameter, grid) in enumerate(zip(effect.parameters, effect.grids(wheels), strict=True))
        if i >= len(gate) and i not in amplitudes and grid and not parameter.estimated
    ]
    return gate + rest + _together(effect, rest)


def _together(effect: Effect, alone: Sequence[Move]) -> list[Move]:
    """Of lengths: their ratio shows more than either."""
    lengths = [move.which for move in alone if move.step == 0.0 and effect.parameters[move.which].unit == "m"]
    return [Move(one, 0.0, beside=other) for one, other in pairwise(lengths)]


def is_open(effect: Effect, values: Array) -> bool:
    if effect.gate is Gate.WHILE:
        return bool(values[1] > 0)
    if effect.gate is Gate.INSIDE:
        return bool(values[1] > values[0] and values[3] > values[2])
    return True


def _product(left: Array, right: Array) -> Array:
    return np.asarray(np.tensordot(left, right, ((0, 1), (0, 1))))
