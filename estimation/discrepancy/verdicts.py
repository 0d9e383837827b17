"""Why each candidate of a step of the search was added, or was not, in words."""

from __future__ import annotations

from cartgrasp.effects import Effect

from .plausible import ODDS, is_plausible
from .search import SURE, WORTH, Attempt, Refit, Step

ADDED = "added"
TOO_LITTLE = "less than needed"
SIMPLER = "a simpler one does as well"
BETTER = "another one explains more"
UNSTEADY = "not surely so, from stretch to stretch"
RARER = "explains as much, and is rarer"
ODD = "nobody would call it so at these values"


def called(one: Attempt) -> str:
    """The effect's name; of a law, what it is a law of."""
    candidate = one.candidate
    return candidate.effect.name if isinstance(candidate, Refit) else candidate.name


def verdict(step: Step, one: Attempt) -> str:
    """Of one of a step's attempts."""
    if one is step.added:
        return ADDED
    if one.gain < WORTH:
        return TOO_LITTLE
    if one.gain < SURE * one.error:
        return UNSTEADY
    fitted = one.candidate if one.model is not None else None
    if one.model is not None and isinstance(fitted, Effect) and not is_plausible(fitted, one.model.cart.wheel_set):
        return ODD
    if step.added is None:
        return TOO_LITTLE
    if one.gain >= step.added.gain:
        return SIMPLER
    return RARER if one.gain - _odds(one) >= step.added.gain - _odds(step.added) else BETTER


def _odds(one: Attempt) -> float:
    """What is in the gain for how usual it is."""
    return ODDS.get(called(one), 0.0)
