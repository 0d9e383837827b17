"""What a search has added, and does not need any more: what later effects explain as well, and what harms."""

from __future__ import annotations

from collections.abc import Mapping

from cartgrasp.effects import ConstraintEffect, Effect

from .fitted import Fitted
from .held_out import HeldOut
from .judgement import ENOUGH, LEAST_GAIN, LEAST_LIKELIHOOD, LEAST_OF_REST, Judge

NEARLY = 0.75
"""Of the log of the Bayes factor, of an effect that looks like another: the rest may be the world's other form."""
HARM, LEAST_GAP = 1.1, 1e-9
"""Times the gap without an effect: more, and its name is no explanation; and m."""


def still_plausible(fitted: Fitted, judge: Judge) -> Fitted:
    """Without those that were added before the last one, and that nobody would call so at the values that they have
    beside it: they stood for it too."""
    earlier = {effect.key for effect in fitted.added[:-1]}
    for effect in fitted.cart.effects:
        if effect.key in earlier and judge.implausible(effect):
            fitted = fitted.without(effect.key)
    return fitted


def pruned(fitted: Fitted, held_out: HeldOut) -> tuple[Fitted, list[tuple[str, str]]]:
    """Without what the later effects have made superfluous, of two of which either would do the earlier stays; and
    without what makes simulations of stretches that no fit saw worse, however well it fits the wrenches. Also, by the
    key of one that stays, the name of a superfluous one that would do nearly as well in its place."""
    replaced = list[tuple[str, str]]()
    while True:
        less = {effect.key: held_out.without(fitted, effect.key) for effect in fitted.added}
        gone = _superfluous(fitted, less, held_out)
        if gone:
            replaced += [(key, _name(gone, fitted)) for key in less if key != gone and _nearly(gone, key, less)]
        gone = gone or _harmful(fitted, less, held_out)
        if not gone:
            return fitted, replaced
        fitted = less[gone]


def _name(key: str, fitted: Fitted) -> str:
    return next(effect.name for effect in fitted.added if effect.key == key)


def _nearly(gone: str, stays: str, less: Mapping[str, Fitted]) -> bool:
    """Whether what goes explains nearly as much as what stays, each without the other."""
    neither = less[gone].without(stays).chi_squared()
    return neither - less[stays].chi_squared() > NEARLY * max(neither - less[gone].chi_squared(), 0.0)


def _superfluous(fitted: Fitted, less: Mapping[str, Fitted], held_out: HeldOut) -> str:
    """The key of an effect, but the last, without which it is as good; empty where there is none."""
    keys = list(less)
    gone = next((e.key for e in fitted.added[:-1] if _is_superfluous(e, fitted, less[e.key], held_out)), "")
    for later in keys[keys.index(gone) + 1 :] if gone else ():
        if 0.5 * (less[later].chi_squared() - less[gone].chi_squared()) / fitted.excess < ENOUGH:
            gone = later
    return gone


def _harmful(fitted: Fitted, less: Mapping[str, Fitted], held_out: HeldOut) -> str:
    """The key of the effect with which held-out stretches are the farthest away; empty where none harms."""
    harm = {effect.key: _harm(effect, fitted, less[effect.key], held_out) for effect in fitted.added}
    worst = max(harm, key=lambda key: harm[key], default="")
    return worst if worst and harm[worst] >= HARM else ""


def _harm(effect: Effect, fitted: Fitted, less: Fitted, held_out: HeldOut) -> float:
    """How many times as far away held-out stretches are with an effect as without."""
    if isinstance(effect, ConstraintEffect) or effect.gate.ends:
        return 0.0
    return held_out.gap(fitted) / max(held_out.gap(less), LEAST_GAP)


def _is_superfluous(effect: Effect, fitted: Fitted, less: Fitted, held_out: HeldOut) -> bool:
    if isinstance(effect, ConstraintEffect) or effect.gate.ends:
        return False
    gain = held_out.gain(less, fitted)
    needed = gain.share >= LEAST_GAIN or gain.of_rest >= LEAST_OF_REST
    return not needed and held_out.likelihood(less, fitted) < LEAST_LIKELIHOOD
