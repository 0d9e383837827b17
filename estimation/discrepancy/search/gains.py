"""What candidates gain beside a model, and by how much two models must differ to be told apart."""

from __future__ import annotations

import numpy as np

from cartgrasp.effects import ConstraintEffect, Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.effects.time_delay import TimeDelay

from ...weak_form.score import Score
from .candidates import Family, amplitudes_of, families
from .laws import Law
from .model import Model
from .plausibility import PRIOR_LOG_ODDS
from .scored_candidates import ScoredCandidate

MIN_GAIN_NATS = 10.0
"""Least gain in score of what is added; also how much less something simpler than what acts for a while may explain."""
CONFUSABLE_NATS = float(np.log(100.0))
"""Difference in score by which a candidate still explains about as much."""
GAIN_SIGMAS = 1.5
"""Standard errors of its gain, over stretches, that what acts all the time gains at least (Vehtari et al., 2017)."""


def score_gain(base: Score, score: Score, colour: float | None) -> float:
    """How much better a score is: in pieces, and, of what acts everywhere, in stretches too. What happens once, beside
    noise of a `colour`, gains as many times less."""
    pieces = float(score.pieces.sum() - base.pieces.sum())
    return pieces / colour if colour is not None else min(pieces, float(score.stretches.sum() - base.stretches.sum()))


def standard_error(base: Score, score: Score) -> float:
    """Standard error of a gain, by how it differs from stretch to stretch."""
    gains = score.stretches - base.stretches
    return float(len(gains) ** 0.5 * gains.std())


def margin(one: Model, best: Model, *gates: Gate) -> float:
    """How much less a model may explain: what chance makes of the difference from stretch to stretch. For what acts at
    a time or a place alone, by its gate, it is at least what a name is worth; and no more for what happens once, of
    which other stretches tell nothing."""
    if any(gate.ends for gate in gates):
        return MIN_GAIN_NATS
    least = CONFUSABLE_NATS if all(gate is Gate.ALWAYS for gate in gates) else MIN_GAIN_NATS
    return max(least, GAIN_SIGMAS * standard_error(one.score, best.score))


def scored_candidate(model: Model, effect: Effect, tried: int) -> ScoredCandidate:
    """Candidate of an effect: its score where the model's parameters move a little, if at all, and the effect with its
    amplitudes."""
    colour: float | None = None
    if isinstance(effect, TimeDelay):
        score = model.felt_by(model.cart.with_effect(effect)).score
        fitted: Effect = effect
    else:
        columns, std = model.columns_of(effect)
        score = model.with_columns(columns, std)
        own, values = score.fit[-columns.shape[2] :], effect.values.copy()
        if isinstance(effect, ConstraintEffect):
            fitted = effect.scaled(float(own[0]))
        else:
            values[amplitudes_of(effect)] += own
            fitted = effect.with_values(values)
            if effect.gate is not Gate.ALWAYS:
                colour = model.variance_inflation_beside(model.rows_with(columns), score) if effect.gate.ends else 1.0
    gain = score_gain(model.score, score, colour) - float(np.log(tried))
    return ScoredCandidate(fitted, gain + PRIOR_LOG_ODDS.get(effect.name, 0.0), tried)


def added_score_gain(less: Model, model: Model, effect: Effect) -> float:
    """What an effect of a model is worth, against one without."""
    return score_gain(less.score, model.score, variance_inflation_of(model, effect))


def variance_inflation_of(model: Model, candidate: Effect | Law) -> float | None:
    """Colour of what is left with a candidate that does not act everywhere, else None: a push is like anything that
    drifts."""
    if isinstance(candidate, Law) or candidate.gate is Gate.ALWAYS:
        return None
    return model.variance_inflation if candidate.gate.ends else 1.0


def without_amplitudes(effect: Effect) -> Effect:
    """The effect at the same settings, without amplitudes."""
    if isinstance(effect, ConstraintEffect):
        return type(effect).usual(effect.label)
    values = effect.values.copy()
    own = amplitudes_of(effect)
    values[own] = [effect.parameters[i].absent for i in own]
    return effect.with_values(values)


def added(model: Model) -> list[Effect]:
    known = {effect.key for effect in model.guess.effects}
    return [effect for effect in model.cart.effects if effect.key not in known]


def every_family(model: Model) -> list[Family]:
    """Families of candidates, of the vocabulary and from outside."""
    return families(model.cart, model.logs[0].wrenches.arms, model.candidates)
