"""What was added, looked at again beside all that was added since: its settings, its worth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cartgrasp.effects import ConstraintEffect

from .gains import added, added_score_gain, score_gain, scored_candidate, without_amplitudes
from .laws import Law
from .model import Model
from .plausibility import PRIOR_LOG_ODDS
from .refine import refined
from .scored_candidates import Refit
from .screening import Screen


def retuned(model: Model) -> Model:
    """The model with the settings of what was added where they are best beside all else."""
    for effect in added(model):
        if isinstance(effect, ConstraintEffect):
            continue
        less = model.refitted(model.cart.without_effect(effect.key))
        screen = Screen(less)
        best = refined(without_amplitudes(effect), screen.gain)
        if not np.allclose(best.values, without_amplitudes(effect).values):
            fitted = scored_candidate(less, best, 1).candidate
            assert not isinstance(fitted, Law | Refit)
            model = less.refitted(less.cart.with_effect(fitted))
    return model


def pruned(model: Model, least: float) -> Model:
    """The model without what later additions have made superfluous."""
    while len(added(model)) + len(model.laws) > 1:
        losses = []
        for effect in added(model):
            less = model.refitted(model.cart.without_effect(effect.key))
            losses.append((added_score_gain(less, model, effect) + PRIOR_LOG_ODDS.get(effect.name, 0.0), less))
        for law in model.laws:
            less = replace(model, laws=tuple(one for one in model.laws if one is not law)).refitted(model.cart)
            losses.append((score_gain(less.score, model.score, None), less))
        loss, less = min(losses, key=lambda one: one[0])
        if loss >= least:
            break
        model = less.rewhitened()
    return model
