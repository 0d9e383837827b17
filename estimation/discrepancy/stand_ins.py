"""Names that stand in for what has none: pushes, places and loads, of which enough can follow anything.

What happens once, or at one place, has a few numbers for each time and place that it is given. A third of one kind, a
second after which something is left, or one beside which much is, is no more than a picture of a force that nobody
knows.
"""

from __future__ import annotations

from collections import Counter

from cartgrasp.effects import ConstraintEffect, Effect
from cartgrasp.effects.effect import Gate

from .fitted import Fitted
from .held_out import BEYOND_NOISE, HeldOut

LITTLE, MUCH, MOST = 0.03, 0.25, 0.5
"""Of the squared gap above the noise floor: where no more than the first is left, two of a kind may pass; where more
than the second is, nothing that passes has a name; where more than the third, no force has."""

AT_BEST = 2
"""Of one kind, as of carpets."""


def stand_ins(fitted: Fitted, held_out: HeldOut) -> tuple[str, ...]:
    """Keys of the added effects that lose their names: with the first, all that was found beside it."""
    forces = [effect for effect in fitted.added if not isinstance(effect, ConstraintEffect)]
    kinds = Counter(effect.name for effect in forces)
    left = _left(fitted, held_out) if forces else 0.0

    def is_doubtful(effect: Effect) -> bool:
        passes, most = effect.gate is not Gate.ALWAYS, 1 if left > LITTLE else AT_BEST
        return left > MOST or (passes and (left > MUCH or kinds[effect.name] > most))

    first = next((i for i, effect in enumerate(forces) if is_doubtful(effect)), len(forces))
    return tuple(effect.key for effect in forces[first:])


def _left(fitted: Fitted, held_out: HeldOut) -> float:
    """The share of the nominal model's squared gap above the floor; 0 where all may be noise."""
    nominal, after, floor = held_out.gap(held_out.nominal), held_out.gap(fitted), held_out.floor(fitted)
    if after <= BEYOND_NOISE * floor:
        return 0.0
    return (after**2 - floor**2) / max(nominal**2 - floor**2, after**2 - floor**2)
