"""Why each candidate of a step of the search was added, or was not, in words."""

from __future__ import annotations

from cartgrasp.effects import Effect

from .plausible import is_plausible
from .search import Attempt, Step

ADDED = "added"
TOO_LITTLE = "less than needed"
SIMPLER = "a simpler one does as well"
BETTER = "another one explains more"
ODD = "nobody would call it so at these values"


def verdict(step: Step, one: Attempt) -> str:
    """Of one of a step's attempts."""
    if step.added is not None and one.key == step.added.key:
        return ADDED
    if one.model is None:
        return TOO_LITTLE
    if isinstance(one.candidate, Effect) and not is_plausible(one.candidate, one.model.cart.wheel_set):
        return ODD
    if step.added is None:
        return TOO_LITTLE
    return SIMPLER if one.gain >= step.added.gain else BETTER
