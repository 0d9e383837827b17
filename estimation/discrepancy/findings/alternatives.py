"""What explains about as much as what was added, or was left out: how probable it is, how unsure it makes a cart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cartgrasp.effects import Effect
from cartgrasp.frames import Array

from ...weak_form.coordinates import coordinates
from ..search.gains import CONFUSABLE_NATS
from ..search.laws import Law
from ..search.model import Model
from ..search.scored_candidates import Refit, ScoredCandidate, SearchStep

NATS_PER_NUMBER = 2.0
"""Nats for each number by which less something takes."""
MAX_LOG_ODDS = 100.0
"""Largest log odds (nats)."""


def alternatives(step: SearchStep) -> list[tuple[float, ScoredCandidate]]:
    """What explains about as much as what a step added, an effect beside an effect, each with its odds against that."""
    own, found = step.added, list[tuple[float, ScoredCandidate]]()
    if own is None or isinstance(own.candidate, Refit):
        return found
    for one in step.attempts:
        if one.key == own.key or not _is_alternative(one, own):
            continue
        if one.gain > max(own.gain - CONFUSABLE_NATS, 0.0):
            more = max(one.numbers - own.numbers, 0) if one.gain > own.gain else 0
            found.append((float(np.exp(min(one.gain - own.gain - NATS_PER_NUMBER * more, 0.0))), one))
    return found


def _is_alternative(one: ScoredCandidate, own: ScoredCandidate) -> bool:
    """Whether it says another thing: a law of the same variable is the same law, and no rival of an effect."""
    if isinstance(one.candidate, Law):
        return isinstance(own.candidate, Law) and one.candidate.of != own.candidate.of
    return isinstance(one.candidate, Effect)


def _left_out(step: SearchStep) -> list[tuple[float, ScoredCandidate]]:
    """What a step without an addition was too careful to add, each with its odds against nothing."""
    return [(float(np.exp(min(one.gain, MAX_LOG_ODDS))), one) for one in step.attempts if one.model is not None]


def between_model_covariance(steps: Sequence[SearchStep], final: Model, count: int) -> Array:
    """Covariance (count, count) of the first coordinates of a cart: mean squares of what rivals, and what was left out,
    would make of them."""
    found = np.zeros((count, count))
    for step in steps:
        known, base = (
            (_left_out(step), final) if step.added is None else (alternatives(step), step.added.model or final)
        )
        total, own = 1.0 + sum(odds for odds, _ in known), coordinates(base.cart)[:count]
        for odds, one in known:
            if one.model is not None:
                off = coordinates(one.model.cart)[:count] - own
                found += odds / total * np.outer(off, off)
    return found
