"""The motion of carts whose wheels don't roll as they should: smoothed again with what a constraint effect makes of it.

Constraint effects are read from poses alone, before any force is looked at; how large one is depends a little on the
motion that was smoothed with it, so both are worked out in turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from cartgrasp.effects import Effect
from cartgrasp.model import CartModel

from ..batch.wrench_regression import WrenchRegression
from .fitted import Fitted
from .log_check import moving
from .sideways import sideways_trials

ROUNDS = 2


def bent(
    whole: Sequence[WrenchRegression], cart: CartModel, added: tuple[Effect, ...], effect: Effect
) -> tuple[tuple[WrenchRegression, ...], Effect]:
    """Logs smoothed anew for a cart with those that were added and one more, and that one as large as it is there."""
    whole = tuple(whole)
    for _ in range(ROUNDS):
        other = replace(cart, effects=(*cart.effects, *added, effect))
        whole = tuple(WrenchRegression(r.log, other, r.noise, r.size > 1).wary() for r in whole)
        known = on_moving_rows(whole, cart, (*added, effect)).cart.without_effect(effect.key)
        found = (trial.finding.effect for trial in sideways_trials(whole, known))
        effect = next(one for one in found if type(one) is type(effect))
    return whole, effect


def on_moving_rows(whole: Sequence[WrenchRegression], cart: CartModel, added: tuple[Effect, ...]) -> Fitted:
    return Fitted(tuple(regression.within(moving(regression)) for regression in whole), cart, added)


def with_its_noise(whole: Sequence[WrenchRegression], fitted: Fitted) -> tuple[tuple[WrenchRegression, ...], Fitted]:
    """Both with wrench noise of the colour that is read off the residuals."""
    fitted = fitted.coloured()
    return tuple(r.coloured(seen.colour) for r, seen in zip(whole, fitted.regressions, strict=True)), fitted
