"""What explains about as much as what was added: how probable each is, and how much less sure that makes the cart."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cartgrasp.effects import Effect
from cartgrasp.frames import Array

from ..weak_form.fit import coordinates
from .search import Attempt, Step

CONFUSABLE = np.log(100.0)
"""Nats: by which less a rival may explain."""
SIMPLER = 2.0
"""Nats for each number by which less something takes."""


def rivals(step: Step) -> list[tuple[float, Attempt]]:
    """Effects that explain about as much as the one that a step added, each with its odds against that."""
    own, found = step.added, list[tuple[float, Attempt]]()
    if own is None or not isinstance(own.candidate, Effect):
        return found
    for one in step.attempts:
        if one.key == own.key or not isinstance(one.candidate, Effect):
            continue
        if one.gain > max(own.gain - CONFUSABLE, 0.0):
            more = max(one.numbers - own.numbers, 0) if one.gain > own.gain else 0
            found.append((float(np.exp(min(one.gain - own.gain - SIMPLER * more, 0.0))), one))
    return found


def undecided(steps: Sequence[Step], count: int) -> Array:
    """Covariance (count, count) of the first coordinates of a cart: mean squares of what rivals would make of them."""
    found = np.zeros((count, count))
    for step in steps:
        known = rivals(step)
        total = 1.0 + sum(odds for odds, _ in known)
        for odds, one in known:
            if one.model is not None and step.added is not None and step.added.model is not None:
                own, other = (coordinates(model.cart)[:count] for model in (step.added.model, one.model))
                found += odds / total * np.outer(other - own, other - own)
    return found
