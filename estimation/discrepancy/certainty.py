"""How sure the values of a chosen structure are, where its forms are not quite those of the world.

A form that is a little wrong leaves residuals that are no noise, in one direction more than in another, and alike
within a manoeuvre. Each direction is weighed by what is left along it; and the pulls of whole manoeuvres, which cancel
at the best fit, say by their scatter how far it may be off: White's (1980) sandwich `A⁻¹ (Σ g gᵀ) A⁻¹`, with stretches
that belong together in one pull (Liang and Zeger, 1986). The larger deviation of the two counts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import chi2

from cartgrasp.effects import ConstraintEffect, Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import ParameterEstimate

from ..batch.wrench_regression import BLOCK
from ..parameter_report import ParameterReport
from ..prior import report_names
from .dictionary import amplitudes_of
from .fitted import Fitted
from .forms import form_sizes
from .manoeuvres import manoeuvres, settled
from .settings import FORM_SHARE, settled_setting, swelling

OUTLYING = 4.0
"""Times the usual scatter: what an accident counts at most."""
MOST_LOST = 1.5
"""Times the deviation: what fewer rows may cost."""
LEAST_DEVIATIONS = 2.5
"""By which an effect that is named differs from none."""


@dataclass(frozen=True)
class Certainty:
    """The structure with its directions in balance, and the cart; its parameters; standard deviations of settings by
    key, and by how many deviations each effect's amplitudes differ from none, where a load lies beside."""

    fitted: Fitted
    cart: CartModel
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
            return _told(fitted, found), tuple(removed)
        fitted, removed = fitted.without(key), [*removed, key]


def certain(fitted: Fitted) -> Certainty:
    settings: dict[str, float] = {}
    for effect in fitted.added:
        moved, found = settled_setting(fitted, effect)
        fitted, settings = fitted.with_changed(effect, moved), settings | found
    fitted = balanced(_rolling(fitted))
    covariance, share = _covariance(fitted)
    parameters = ParameterReport(fitted.structure, fitted.prior).of(fitted.cart.parameters, covariance, share)
    return Certainty(fitted, fitted.cart, parameters, settings, _deviations(fitted, covariance))


def _told(fitted: Fitted, known: Certainty) -> Certainty:
    """With what effects take from the wheels written out, and pushes that rise and fall from where they begin to where
    they end."""
    parameters, settings = dict(known.parameters), dict(known.settings)
    added, wheels = {effect.key for effect in fitted.added}, known.cart.wheel_set
    effects = [effect.told(wheels) if effect.key in added else effect for effect in known.cart.effects]
    for k, effect in enumerate(effects):
        found = swelling(fitted, effect) if effect.gate is Gate.WHILE and effect.key in added else None
        if found is not None:
            effects[k], deviations = found
            settings |= deviations
            share = float(effect.values[1] / effects[k].values[1])
            for i in _may_be_estimated(effect):
                one = parameters[effect.keys[i]]
                value = float(effects[k].values[i])
                parameters[effect.keys[i]] = replace(one, value=value, std=share * one.std)
    return replace(known, cart=replace(known.cart, effects=tuple(effects)), parameters=parameters, settings=settings)


def _deviations(fitted: Fitted, covariance: Array) -> dict[str, float]:
    places, found = {name: i for i, name in enumerate(report_names(fitted.cart))}, dict[str, float]()
    for effect in fitted.added:
        own = [i for i in amplitudes_of(effect) if covariance[places[effect.keys[i]], places[effect.keys[i]]] > 0]
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
        whole = regression.evidence(fitted.cart.parameters, delay).part(fitted.free)
        evidence, weights = whole.kept(fitted.base.information), whole.weights(fitted.base.information)
        first = line.nodes[line.ends(BLOCK)[:-1]] // regression.size
        number = manoeuvres(regression.motion, not regression.cart.constraints.no_rotation)[first]
        m, k = number.max(initial=0) + 1, len(fitted.free)
        there = np.zeros((m, k))
        np.add.at(there, number, evidence.pulls / told.noise_excess)
        late = evidence.blocks.sum(axis=0)[-1] / told.noise_excess
        own = sizes[at : at + len(forms.family)]
        weighed = np.repeat(weights, np.diff(line.ends(BLOCK)))[:, None, None] * line.by[..., fitted.free]
        form = np.tensordot(weighed, line.whitened(forms.columns), ((0, 1), (0, 1))) / told.noise_excess
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
