"""What to record next: what this motion lacks, what tells effects apart, and what a rest may follow."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from cartgrasp.information import WrenchNoise

from .separating import Hands, rivals_named, separating

if TYPE_CHECKING:
    from .diagnosis import Diagnosis
    from .named import NamedEffect

MORE_MOTION = (
    "push forward and backward, at a slow and a fast steady speed, along two headings and through turns both ways: "
    "effects that this log shows alike differ there"
)


def next_experiments(found: Diagnosis) -> tuple[str, ...]:
    """The most useful first."""
    return tuple(dict.fromkeys(_told(found)))


def _told(found: Diagnosis) -> Iterator[str]:
    for effect in found.effects:
        others = [name for name in effect.confusable_with if name != effect.name]
        if others:
            yield _to_tell_apart(found, effect, others)
        if effect.name in effect.confusable_with:
            yield f"push with one arm alone, then with another: that tells whose {effect.name} it is"
    shown = found.isolability.values()
    if sum(not one.is_shown for one in shown) > len(shown) / 2:
        yield MORE_MOTION
    for law in (*found.final.laws, *found.withdrawn)[:1]:
        yield f"repeat the motion with another {law.name}, to see whether the force follows it"
    if found.verdict in ("unexplained", "partly_explained"):
        yield "record the same motion twice: what comes back is the cart's, what does not is noise"


def _to_tell_apart(found: Diagnosis, effect: NamedEffect, others: list[str]) -> str:
    key = next(one.key for one in found.cart.effects if (one.name, one.label) == (effect.name, effect.label))
    hands = _hands(found)
    lasting = [name for name in others if rivals_named(name, found.cart.without_effect(key), hands)]
    others = lasting or others  # what acts at a place or a time is told apart by no motion
    best = separating(found.cart, key, others, hands) if hands.contacts else None
    if best is None:
        return MORE_MOTION
    names = " or ".join(others)
    return f"to tell {effect.name} from {names}: {best.says}; they differ there by {best.deviations:.0f} deviations"


def _hands(found: Diagnosis) -> Hands:
    """Where the arms hold in the first log that has each, and the first log's noise."""
    logs = [balances.log for balances in found.final.logs]
    contacts = {arm: np.nanmedian(own.contact, axis=0) for log in reversed(logs) for arm, own in log.arms.items()}
    check = found.checks[0]
    return Hands(contacts, WrenchNoise(check.noise.force, check.noise.moment, check.rate))
