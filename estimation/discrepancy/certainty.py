"""How sure the values of a chosen structure are, where its forms are not quite those of the world.

A form that is a little wrong leaves residuals that are no noise, in one direction more than in another, and alike
within a manoeuvre. Each direction is weighed by what is left along it; and the pulls of whole manoeuvres, which cancel
at the best fit, say by their scatter how far it may be off: White's (1980) sandwich `A⁻¹ (Σ g gᵀ) A⁻¹`, with stretches
that belong together in one pull (Liang and Zeger, 1986). The larger deviation of the two counts. Times, places and
frequencies, which no linear fit gives, have the deviation of their posterior along the line through the best.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from cartgrasp.effects import Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.frames import Array
from cartgrasp.motion import ParameterEstimate

from ..batch.wrench_regression import BLOCK
from ..parameter_report import ParameterReport
from .dictionary import may_be_amplitudes
from .fitted import Fitted
from .manoeuvres import manoeuvres
from .refinement import Move, Refiner, is_open, moves

FORM = {"s": 0.05, "m": 0.03}
"""How much less sharp the world is than a step in time or place."""
FORM_SHARE = 0.05
"""Of every other value of an effect: how near to one another two forms are that have one name."""
OUTLYING = 4.0
"""Times the usual scatter: what an accident counts at most."""
FIRST, FIRST_SHARE, DOUBLINGS = {"s": 0.04, "m": 0.02}, 0.02, 7
UNLIKELY = 8.0
"""Difference of logs of likelihoods beyond which nobody looks."""
FINE = 400


@dataclass(frozen=True)
class Certainty:
    """The structure with its directions in balance; its parameters; standard deviations of settings by key."""

    fitted: Fitted
    parameters: dict[str, ParameterEstimate]
    settings: dict[str, float]


def certain(fitted: Fitted) -> Certainty:
    settings: dict[str, float] = {}
    for effect in fitted.added:
        moved, found = _settled(fitted, effect)
        fitted, settings = _with(fitted, effect, moved), settings | found
    fitted = balanced(fitted)
    return Certainty(fitted, _parameters(fitted), settings)


def _with(fitted: Fitted, effect: Effect, moved: Effect) -> Fitted:
    added = tuple(moved if one is effect else one for one in fitted.added)
    known = tuple(moved if one.key == moved.key else one for one in fitted.cart.effects)
    return replace(fitted, added=added, start=replace(fitted.cart, effects=known).parameters)


def balanced(fitted: Fitted) -> Fitted:
    """With the noise along each free direction as large as what is left there."""
    scatter, found = fitted.scatter, []
    for k, regression in enumerate(fitted.regressions):
        own = scatter.log == k
        variance = np.diagonal(np.linalg.inv(scatter.information[own]), axis1=1, axis2=2)
        chi = scatter.mean[own] ** 2 / variance
        usual = np.median(chi, axis=0) / chi2.median(1)
        found.append(
            regression.louder(np.maximum(np.minimum(chi, OUTLYING * np.maximum(usual, 1.0)).mean(axis=0), 1.0))
        )
    return replace(fitted, regressions=tuple(found), start=fitted.cart.parameters)


def _parameters(fitted: Fitted) -> dict[str, ParameterEstimate]:
    own, known = fitted.free[:-1], fitted.identification
    covariance = known.covariance[np.ix_(own, own)]
    drawn = covariance @ _drawn(fitted)
    prior = covariance @ fitted.base.information[:-1, :-1] @ covariance
    robust = np.diagonal(drawn @ drawn.T + prior)
    wider = np.sqrt(np.maximum(robust / np.diagonal(covariance), 1.0))
    whole = known.covariance.copy()
    whole[np.ix_(own, own)] = wider[:, None] * covariance * wider
    share = np.ones(len(whole))
    share[own] = np.sqrt(np.diagonal(whole)[own] * np.diagonal(fitted.base.information)[:-1])
    return ParameterReport(fitted.structure, fitted.prior).of(known.model_parameters, whole + _form(fitted), share)


def _form(fitted: Fitted) -> Array:
    """Covariance (p, p) of what an added effect's value would be in another form."""
    n = sum(len(effect.values) for effect in fitted.added)
    absent = [parameter.absent for effect in fitted.added for parameter in effect.parameters]
    size = np.zeros(len(fitted.cart.parameters))
    size[len(size) - n :] = FORM_SHARE * np.abs(fitted.cart.parameters[len(size) - n :] - absent)
    return np.diag(size**2)


def pulls(fitted: Fitted) -> list[tuple[Array, Array]]:
    """Of each log: pulls of its manoeuvres on the free parameters and its delay (p + 1, manoeuvres), and the
    information about the delay in relation to all (p + 1,)."""
    found = []
    for (regression, line, delay), told in zip(fitted.linearised, fitted.identification.logs, strict=True):
        evidence = regression.evidence(fitted.cart.parameters, delay).part(fitted.free).kept(fitted.base.information)
        first = line.nodes[line.ends(BLOCK)[:-1]] // regression.size
        number = manoeuvres(regression.motion, not regression.cart.constraints.no_rotation)[first]
        sums = np.zeros((number.max(initial=0) + 1, len(fitted.free)))
        np.add.at(sums, number, evidence.pulls)
        found.append((sums.T / told.noise_excess, evidence.blocks.sum(axis=0)[-1] / told.noise_excess))
    return found


def _drawn(fitted: Fitted) -> Array:
    """Pulls (p, manoeuvres) of all logs, with each log's delay as it fits best, as many as are free to differ."""
    found = []
    for each, late in pulls(fitted):
        n = int(each.any(axis=0).sum())
        follows = late[:-1] / (late[-1] + fitted.base.information[-1, -1])
        found.append((each[:-1] - follows[:, None] * each[-1]) * np.sqrt(n / max(n - 1, 1)))
    return np.concatenate(found, axis=1)


def _settled(fitted: Fitted, effect: Effect) -> tuple[Effect, dict[str, float]]:
    """An effect with times in the middle of where they may be, and its settings' deviations."""
    amplitudes = np.flatnonzero(may_be_amplitudes(effect))
    searched = [move for move in moves(effect, amplitudes) if not effect.parameters[move.which].estimated]
    if not searched:
        return effect, {}
    own = next(one for one in fitted.cart.effects if one.key == effect.key)
    refiner, excess = Refiner(fitted.without(effect.key)), max(fitted.excess, 1.0)
    if len(fitted.added) > 1:  # it was searched for without some of the others
        own = refiner.refined(own, amplitudes, _prior_std(own, amplitudes))[0]
    values, found = own.values.copy(), dict[str, float]()
    for move in searched:
        parameter = own.parameters[move.which]
        offset, std = _posterior(refiner, own, amplitudes, move, excess)
        if own.gate.passes and offset != 0.0:
            moved = replace(move, step=offset).applied(values, 1.0)
            values = values if moved is None else moved
        floor = FORM.get(parameter.unit, FORM_SHARE * abs(float(values[move.which])))
        found[own.keys[move.which]] = float(np.hypot(std, floor))
    if own.gate is Gate.WHILE:  # its start moves one end, its duration the other
        found[own.keys[1]] = float(np.hypot(found[own.keys[0]], found[own.keys[1]]))
    return own.with_values(values), found


def _prior_std(effect: Effect, amplitudes: np.ndarray) -> Array:
    return np.array([2 * effect.parameters[i].typical for i in amplitudes])


def _posterior(
    refiner: Refiner, effect: Effect, amplitudes: np.ndarray, move: Move, excess: float
) -> tuple[float, float]:
    """Mean, from where it is, and standard deviation of a setting, with the amplitudes as they fit best."""
    absent, unit = effect.values.copy(), effect.parameters[move.which].unit
    absent[amplitudes] = [effect.parameters[i].absent for i in amplitudes]
    std = _prior_std(effect, amplitudes)
    first = FIRST.get(unit, FIRST_SHARE * abs(float(effect.values[move.which])))
    best = refiner.gain(effect.with_values(absent), amplitudes, std).value
    known = {0.0: 0.0}
    for sign in (1.0, -1.0):
        for k in range(DOUBLINGS):
            offset = sign * first * 2**k
            tried = replace(move, step=offset).applied(absent, 1.0)
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
