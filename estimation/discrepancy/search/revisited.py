"""What was added, looked at again beside all that was added since: its settings, its form, its worth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cartgrasp.effects import ConstraintEffect, Effect
from cartgrasp.effects.effect import Gate

from .attempts import Refit
from .gains import WORTH, absent, added, added_worth, attempt, every_family, margin, worth
from .laws import Law
from .model import Model
from .plausible import ODDS, is_plausible
from .refine import refined
from .screening import Screen

MOST_FORMS = 2
"""Most other forms of a law that are refitted."""


def searched_again(model: Model) -> Model:
    """The model with the settings of what was added where they are best beside all else, and with laws as they are
    best: what was missing beside one may have bent it."""
    for law in model.laws:
        model = _other_form(model, law)
    for effect in added(model):
        if isinstance(effect, ConstraintEffect):
            continue
        less = model.refitted(model.cart.without_effect(effect.key))
        screen = Screen(less)
        near = [absent(effect), *_elsewhere(less, screen, effect)]
        best = max((refined(one, screen.gain) for one in near), key=screen.gain)
        if not np.allclose(best.values, absent(effect).values):
            fitted = attempt(less, best, 1).candidate
            assert not isinstance(fitted, Law | Refit)
            model = less.refitted(less.cart.with_effect(fitted))
    return model


def _other_form(model: Model, law: Law) -> Model:
    """The model with another form of a smooth law, the simplest that is not surely worth less beside all else, and
    leaves effects what their names say."""
    less = replace(model, laws=tuple(one for one in model.laws if one is not law)).refitted(model.cart)
    screen = Screen(less)
    gains = [(screen.of_law(one), one) for one in screen.smooth_laws() if one.of == law.of and one.key != law.key]
    enough = screen.of_law(law) - WORTH
    near = sorted((one for one in gains if one[0] > enough), key=lambda one: -one[0])[:MOST_FORMS]
    others = [(one.size, _with_law(less, one)) for _, one in near]
    found = [(law.size, model), *(one for one in others if _keeps_names(one[1]))]
    best = max((one for _, one in found), key=lambda one: worth(less.score, one.score, None))
    alike = [one for one in found if worth(one[1].score, best.score, None) <= margin(one[1], best)]
    return min(alike, key=lambda one: (one[0], -worth(less.score, one[1].score, None)))[1]


def _keeps_names(model: Model) -> bool:
    """Whether somebody who knows carts would still call its added effects so."""
    return all(is_plausible(effect, model.cart.wheel_set) for effect in added(model))


def _with_law(model: Model, law: Law) -> Model:
    return replace(model, laws=(*model.laws, law)).refitted(model.cart)


def _elsewhere(model: Model, screen: Screen, effect: Effect) -> list[Effect]:
    """Where else, or when, an effect may act: what was there alone may have hidden it."""
    if effect.gate is Gate.ALWAYS:
        return []
    known = (family for family in every_family(model) if family.key == effect.key)
    return [absent(one) for family in known for one in screen.best(family)[0]]


def dropped(model: Model, least: float) -> Model:
    """The model without what later additions have made superfluous."""
    while len(added(model)) + len(model.laws) > 1:
        losses = []
        for effect in added(model):
            less = model.refitted(model.cart.without_effect(effect.key))
            losses.append((added_worth(less, model, effect) + ODDS.get(effect.name, 0.0), less))
        for law in model.laws:
            less = replace(model, laws=tuple(one for one in model.laws if one is not law)).refitted(model.cart)
            losses.append((worth(less.score, model.score, None), less))
        loss, less = min(losses, key=lambda one: one[0])
        if loss >= least:
            break
        model = less.rewhitened()
    return model
