"""When, where and how fast an effect acts, and how sure that is: what no linear fit gives.

A setting has the mean and the deviation of its posterior along the line through the best, with the amplitudes as they
fit best there. What somebody pushes rises and falls: for the model the nearest push that acts at once is best, but it
began earlier, and lasted longer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cartgrasp.effects import Effect
from cartgrasp.effects.effect import Gate

from .dictionary import amplitudes_of
from .fitted import Fitted
from .profiles import MEAN, around, half_sine, smeared
from .refinement import Move, Refiner, absent, is_open, moves, prior_std

FORM = {"s": 0.05, "m": 0.03}
"""How much less sharp the world is than a step in time or place."""
FORM_SHARE, FORM_SHARE_OF_LENGTH = 0.05, 0.2
"""Of every other value of an effect: how near to one another two forms of one name are. One caster, which stands for
two, stands a fifth farther away, and trails by a fifth more."""
SMEARED = (0.1, 0.2)
"""s: what smoothed motion makes of a push's edges."""
FIRST, FIRST_SHARE, DOUBLINGS = {"s": 0.04, "m": 0.02}, 0.02, 7
UNLIKELY = 8.0
"""Difference of logs of likelihoods beyond which nobody looks."""
FINE = 400


def settled_setting(fitted: Fitted, effect: Effect) -> tuple[Effect, dict[str, float]]:
    """An effect with times in the middle of where they may be, and its settings' deviations."""
    amplitudes = amplitudes_of(effect)
    every = moves(effect, amplitudes, fitted.cart.wheel_set)
    searched = [move for move in every if not effect.parameters[move.which].estimated]
    if not searched:
        return effect, {}
    own = next(one for one in fitted.cart.effects if one.key == effect.key)
    return _told(Refiner(fitted.without(effect.key)), own, searched, max(fitted.excess, 1.0))


def _told(refiner: Refiner, own: Effect, searched: Sequence[Move], excess: float) -> tuple[Effect, dict[str, float]]:
    values, found = own.values.copy(), dict[str, float]()
    for move in searched:
        parameter = own.parameters[move.which]
        offset, std = _posterior(refiner, own, move, excess)
        if own.gate.passes and offset != 0.0:
            moved = replace(move, step=offset).applied(values, 1.0)
            values = values if moved is None else moved
        share = FORM_SHARE_OF_LENGTH if parameter.unit == "m" else FORM_SHARE
        is_gate = move.which < own.gate.n_parameters
        floor = FORM[parameter.unit] if is_gate else share * abs(float(values[move.which]))
        found[own.keys[move.which]] = float(np.hypot(std, floor))
        if move.beside is not None:
            ratio = float(values[move.beside] / values[move.which])
            found[own.keys[move.beside]] = ratio * found[own.keys[move.which]]
    if own.gate is Gate.WHILE:  # its start moves one end, its duration the other
        found[own.keys[1]] = float(np.hypot(found[own.keys[0]], found[own.keys[1]]))
    return own.with_values(values), found


def swelling(fitted: Fitted, effect: Effect) -> tuple[Effect, dict[str, float]] | None:
    """Of an effect of the fitted cart that acts for a while: from where it begins to where it ends, with its mean size,
    if it rises and falls, and its settings' deviations."""
    amplitudes = amplitudes_of(effect)
    std, sharp = prior_std(effect, amplitudes), Refiner(fitted.without(effect.key))
    others = [sharp, *(sharp.shaped(smeared(width)) for width in SMEARED)]
    least = max(one.gain(absent(effect, amplitudes), amplitudes, std).value for one in others)
    refiner = sharp.shaped(half_sine)
    found, gain = refiner.refined(around(effect), amplitudes, std)
    if gain.value <= least:
        return None
    found, told = _told(refiner, found, moves(found, amplitudes, fitted.cart.wheel_set), max(fitted.excess, 1.0))
    values = found.values.copy()
    values[amplitudes] *= MEAN
    return found.with_values(values), told


def _posterior(refiner: Refiner, effect: Effect, move: Move, excess: float) -> tuple[float, float]:
    """Mean, from where it is, and standard deviation of a setting, with the amplitudes as they fit best."""
    amplitudes = amplitudes_of(effect)
    effect, std = absent(effect, amplitudes), prior_std(effect, amplitudes)
    parameter, value = effect.parameters[move.which], abs(float(effect.values[move.which]))
    first = FIRST.get(parameter.unit, FIRST_SHARE * (value or parameter.typical))
    best = refiner.gain(effect, amplitudes, std).value
    known = {0.0: 0.0}
    for sign in (1.0, -1.0):
        for k in range(DOUBLINGS):
            offset = sign * first * 2**k
            tried = replace(move, step=offset).applied(effect.values, 1.0)
            if tried is None or not is_open(effect, tried) or (effect.with_values(tried).values != tried).any():
                break
            known[offset] = (refiner.gain(effect.with_values(tried), amplitudes, std).value - best) / excess
            if known[offset] < -UNLIKELY:
                break
    at = np.array(sorted(known))
    fine = np.linspace(at[0], at[-1], FINE) if len(at) > 1 else at
    weight = np.exp(np.interp(fine, at, [known[one] for one in at]))
    mean = float(weight @ fine / weight.sum())
    return mean, float(np.sqrt(weight @ (fine - mean) ** 2 / weight.sum()))
