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

from cartgrasp.effects import ConstraintEffect, Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.frames import Array
from cartgrasp.motion import ParameterEstimate

from ..batch.wrench_regression import BLOCK
from ..parameter_report import ParameterReport
from ..prior import report_names
from .dictionary import may_be_amplitudes
from .fitted import Fitted
from .forms import form_sizes
from .manoeuvres import manoeuvres, settled
from .profiles import MEAN, around, half_sine
from .refinement import Move, Refiner, is_open, moves, prior_std

FORM = {"s": 0.05, "m": 0.03}
"""How much less sharp the world is than a step in time or place."""
FORM_SHARE = 0.05
"""Of every other value of an effect: how near to one another two forms of one name are."""
OUTLYING = 4.0
"""Times the usual scatter: what an accident counts at most."""
FIRST, FIRST_SHARE, DOUBLINGS = {"s": 0.04, "m": 0.02}, 0.02, 7
MOST_LOST = 1.5
"""Times the deviation: what fewer rows may cost."""
UNLIKELY = 8.0
"""Difference of logs of likelihoods beyond which nobody looks."""
FINE = 400
LEAST_DEVIATIONS = 2.5
"""By which an effect that is named differs from none."""


@dataclass(frozen=True)
class Certainty:
    """The structure with its directions in balance; its parameters; standard deviations of settings by key, and by how
    many deviations each effect's amplitudes differ from none."""

    fitted: Fitted
    parameters: dict[str, ParameterEstimate]
    settings: dict[str, float]
    deviations: dict[str, float]


def proven(fitted: Fitted) -> tuple[Certainty, tuple[str, ...]]:
    """Without the effects, whose keys are given too, that may as well not be there for all that other forms and the
    scatter of manoeuvres leave sure; the least sure is left out first."""
    removed: list[str] = []
    while True:
        found = certain(fitted)
        key = min(found.deviations, key=lambda one: found.deviations[one], default=None)
        if key is None or found.deviations[key] >= LEAST_DEVIATIONS:
            return found, tuple(removed)
        fitted, removed = fitted.without(key), [*removed, key]


def certain(fitted: Fitted) -> Certainty:
    settings: dict[str, float] = {}
    for effect in fitted.added:
        moved, found = _settled(fitted, effect)
        fitted, settings = fitted.with_changed(effect, moved), settings | found
    fitted = balanced(_rolling(fitted))
    covariance, share = _covariance(fitted)
    parameters = ParameterReport(fitted.structure, fitted.prior).of(fitted.cart.parameters, covariance, share)
    return Certainty(fitted, parameters, settings, _deviations(fitted, covariance))


def _deviations(fitted: Fitted, covariance: Array) -> dict[str, float]:
    places, found = {name: i for i, name in enumerate(report_names(fitted.cart))}, dict[str, float]()
    for effect in fitted.added:
        own = [i for i in _may_be_estimated(effect) if covariance[places[effect.keys[i]], places[effect.keys[i]]] > 0]
        if own and not isinstance(effect, ConstraintEffect):
            at = [places[effect.keys[i]] for i in own]
            size = fitted.cart.parameters[at] - [effect.parameters[i].absent for i in own]
            found[effect.key] = float(np.sqrt(size @ np.linalg.solve(covariance[np.ix_(at, at)], size)))
    return found


def _may_be_estimated(effect: Effect) -> list[int]:
    """Which of its parameters a linear fit gives."""
    return [i for i, parameter in enumerate(effect.parameters) if parameter.estimated]


def _rolling(fitted: Fitted) -> Fitted:
    """On rows on which all wheels roll, and casters and bristles have settled, where these tell nearly as much."""
    chosen = tuple(regression.within(settled(regression)) for regression in fitted.regressions)
    fewer = fitted.on(chosen)
    before, after = (
        np.diagonal(f.identification.covariance)[f.free[:-1]]
        / np.mean([log.noise_excess for log in f.identification.logs])
        for f in (fitted, fewer)
    )
    return fewer if (after < MOST_LOST**2 * before).all() else fitted


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


def _covariance(fitted: Fitted) -> tuple[Array, Array]:
    """Of all parameters (p, p), and what share of what was believed their deviations are (p,)."""
    own, known = fitted.free[:-1], fitted.identification
    covariance = known.covariance[np.ix_(own, own)]
    there, form = (((covariance @ each) ** 2).sum(axis=1) for each in _drawn(fitted))
    there += np.diagonal(covariance @ fitted.base.information[:-1, :-1] @ covariance)
    wider = np.sqrt(np.maximum(there, np.diagonal(covariance) + form) / np.diagonal(covariance))
    whole = known.covariance.copy()
    whole[np.ix_(own, own)] = wider[:, None] * covariance * wider
    share = np.ones(len(whole))
    share[own] = np.sqrt(np.diagonal(whole)[own] * np.diagonal(fitted.base.information)[:-1])
    return whole + _form(fitted), share


def _form(fitted: Fitted) -> Array:
    """Covariance (p, p) of what added effects' values would be in another form."""
    own, size = fitted.free[:-1], np.zeros(len(fitted.cart.parameters))
    size[own] = FORM_SHARE * fitted.shares[:-1].sum(axis=1)
    return np.diag(size**2)


@dataclass(frozen=True)
class Pulls:
    """Of a log's manoeuvres on the free parameters and its delay: those at the best fit (p + 1, manoeuvres), those that
    other forms of added effects would make (p + 1, ...), and the information about the delay in relation
    to all (p + 1,)."""

    there: Array
    form: Array
    late: Array

    def on_parameters(self, background: float) -> tuple[Array, Array]:
        """With the delay as it fits best: those that are there, as many as are free to differ, and those of forms."""
        follows = (self.late[:-1] / (self.late[-1] + background))[:, None]
        n = int(self.there.any(axis=0).sum())
        there, form = (each[:-1] - follows * each[-1] for each in (self.there, self.form))
        return there * np.sqrt(n / max(n - 1, 1)), form


def pulls(fitted: Fitted) -> list[Pulls]:
    """Of each log."""
    found, sizes, at = [], _form_sizes(fitted), 0
    logs = zip(fitted.linearised, fitted.identification.logs, fitted.other_forms, strict=True)
    for (regression, line, delay), told, forms in logs:
        evidence = regression.evidence(fitted.cart.parameters, delay).part(fitted.free).kept(fitted.base.information)
        first = line.nodes[line.ends(BLOCK)[:-1]] // regression.size
        number = manoeuvres(regression.motion, not regression.cart.constraints.no_rotation)[first]
        m, k = number.max(initial=0) + 1, len(fitted.free)
        there = np.zeros((m, k))
        np.add.at(there, number, evidence.pulls / told.noise_excess)
        late = evidence.blocks.sum(axis=0)[-1] / told.noise_excess
        own = sizes[at : at + len(forms.family)]
        form = np.tensordot(line.by[..., fitted.free], line.whitened(forms.columns), ((0, 1), (0, 1)))
        form /= told.noise_excess
        found.append(Pulls(there.T, np.asarray(own * form), late))
        at += len(own)
    return found


def _form_sizes(fitted: Fitted) -> Array:
    """Of the forms of all logs."""
    p, excess = len(fitted.base.pull), fitted.excess
    information, pull = fitted.loose.information.copy(), fitted.loose.pull.copy()
    information[p:, p:] = 0.0
    for (_, line, _), columns in zip(fitted.linearised, fitted.loose_columns, strict=True):
        taught, drawn = line.taught(columns)
        information, pull = information + taught / excess, pull + drawn / excess
    through = information[p:, :p] @ np.linalg.inv(information[:p, :p])
    family = [forms.family for forms in fitted.other_forms]
    return form_sizes(
        information[p:, p:] - through @ information[:p, p:], pull[p:] - through @ pull[:p], np.concatenate(family)
    )


def _drawn(fitted: Fitted) -> tuple[Array, Array]:
    """Pulls (p, ...) of all logs."""
    background = float(fitted.base.information[-1, -1])
    there, form = zip(*(each.on_parameters(background) for each in pulls(fitted)), strict=True)
    return np.concatenate(there, axis=1), np.concatenate(form, axis=1)


def _settled(fitted: Fitted, effect: Effect) -> tuple[Effect, dict[str, float]]:
    """An effect with times in the middle of where they may be, and its settings' deviations."""
    amplitudes = np.flatnonzero(may_be_amplitudes(effect))
    searched = [move for move in moves(effect, amplitudes) if not effect.parameters[move.which].estimated]
    if not searched:
        return effect, {}
    own = next(one for one in fitted.cart.effects if one.key == effect.key)
    if own.gate is Gate.WHILE:
        own, refiner = _shaped(fitted.without(effect.key), own, amplitudes)
    else:
        refiner = Refiner(fitted.without(effect.key))
    excess = max(fitted.excess, 1.0)
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


def _shaped(fitted: Fitted, effect: Effect, amplitudes: np.ndarray) -> tuple[Effect, Refiner]:
    """What acts for a while, from where it begins to where it ends, with its mean size, be it there at once or rise and
    fall; and a refiner of what fits better."""
    std, sharp, swelling = prior_std(effect, amplitudes), Refiner(fitted), Refiner(fitted, profile=half_sine)
    known, least = sharp.refined(effect, amplitudes, std)
    found, gain = swelling.refined(around(known), amplitudes, std)
    if gain.value <= least.value:
        return known, sharp
    values = found.values.copy()
    values[amplitudes] *= MEAN
    return found.with_values(values), swelling


def _posterior(
    refiner: Refiner, effect: Effect, amplitudes: np.ndarray, move: Move, excess: float
) -> tuple[float, float]:
    """Mean, from where it is, and standard deviation of a setting, with the amplitudes as they fit best."""
    absent, unit = effect.values.copy(), effect.parameters[move.which].unit
    absent[amplitudes] = [effect.parameters[i].absent for i in amplitudes]
    std = prior_std(effect, amplitudes)
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
