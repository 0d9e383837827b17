"""The gap that is left when somebody tells which effects act: a measure of what a search for them could reach.

The structure is fitted as the search fits its own, on the same rows, and judged on the same rollouts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cartgrasp.effects import ConstraintEffect, Effect
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from .bent_motion import bent, on_moving_rows, with_its_noise
from .diagnosis import smoothed
from .fitted import Fitted
from .held_out import HeldOut
from .refinement import searched_again


@dataclass(frozen=True)
class KnownStructure:
    """The cart with its effects, all values fitted to all rows, and the `gap` of its report: m, after 1 s."""

    cart: CartModel
    gap: float


def refit(logs: Sequence[RunLog], cart: CartModel, effects: Sequence[Effect]) -> KnownStructure:
    """Of the cart with effects near these values, at which the search for times, places and frequencies begins."""
    whole, added = tuple(smoothed(log, cart) for log in logs), tuple[Effect, ...]()
    for effect in effects:
        if isinstance(effect, ConstraintEffect):
            whole, found = bent(whole, cart, added, effect)
            added = (*added, found)
    whole, fitted = with_its_noise(whole, on_moving_rows(whole, cart, added))
    held_out = HeldOut(Fitted(fitted.regressions, cart) if added else fitted, whole)
    for effect in effects:
        if not isinstance(effect, ConstraintEffect):
            fitted = fitted.with_added(effect).listening()
    if fitted.added:
        fitted = searched_again(fitted, fitted.added).settled()
    return KnownStructure(fitted.cart, held_out.gap(fitted))
