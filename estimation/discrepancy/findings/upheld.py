"""What of an extended model holds on stretches that it did not see."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ...weak_form.band import INERTIAL, Band, pooled
from ..search.attempts import Step
from ..search.gains import added
from ..search.laws import Law
from ..search.model import Model
from ..search.plausible import TOLD
from .certainty import Certainty
from .gap import BEYOND_NOISE
from .held_out import file_rollouts, floor_rollouts, held_out_rollouts
from .refusal import foretells_better
from .rivals import undecided
from .rollouts import Rollouts

MOSTLY = 0.8
"""Share of the squared gap above noise: what closes as much is told though it gains less than `WORTH`."""


def upheld(final: Model, known: Sequence[Band | None]) -> tuple[Model, tuple[Law, ...]]:
    """The model without what does not hold, and the laws that were withdrawn. First go loads that what nobody recorded
    may look like. Then goes, laws first and the last additions before others, what unseen stretches are surely foretold
    better without. That rollouts are no better with it is not enough: rows tell what is fast by many nats, and
    rollouts, which add up, next to nothing of it."""
    final = without(final, within_bracket(final, known))
    laws = final.laws
    for law in laws:
        less = replace(final, laws=tuple(one for one in final.laws if one is not law)).refitted(final.cart).settled()
        final = less if foretells_better(less, final) else final
    for effect in reversed(added(final)):
        less = without(final, [effect.key])
        final = less if foretells_better(less, final) else final
    return final, tuple(law for law in laws if law not in final.laws)


def without(final: Model, keys: Iterable[str]) -> Model:
    """The model fitted anew without added effects."""
    for key in keys:
        final = final.refitted(final.cart.without_effect(key)).settled()
    return final


def within_bracket(final: Model, known: Sequence[Band | None]) -> list[str]:
    """Keys of added loads that are within what the bands leave open of the mass: what moves a cart beside its recorded
    wrenches (a rider who leans) looks like a load that swings or changes."""
    share = pooled([(band, band.bracket / band.mass) for band in known if band is not None])
    most = TOLD * share * final.cart.inertia.mass
    loads = [effect for effect in added(final) if effect.name in INERTIAL]
    return [e.key for e in loads if abs(e.values[e.keys.index(f"{e.key}.mass")]) < most]


def closes_most(less: Model, more: Model) -> bool:
    """Whether a model closes most of what another leaves, if that is beyond noise, on stretches that it did not see."""
    floor = rollout_error(floor_rollouts(more))
    best = _known_error(less)
    if best <= BEYOND_NOISE * floor:
        return False
    return rollout_error(held_out_rollouts(more)) ** 2 - floor**2 < (1.0 - MOSTLY) * (best**2 - floor**2)


def _known_error(model: Model) -> float:
    """Rollout error (m) of the cart as it is believed, or of the model where that foretells better."""
    return min(rollout_error(file_rollouts(model)), rollout_error(held_out_rollouts(model)))


def rollout_error(rolled: Rollouts) -> float:
    """Rollout error (m) after a second; infinite where none goes so far."""
    return float(np.nan_to_num(rolled.gaps()[1], nan=np.inf)) if len(rolled.error) else np.inf


def certainty_of(final: Model, steps: Sequence[Step], known: Sequence[Band | None]) -> Certainty:
    told = tuple(band for band in known if band is not None)
    return Certainty(final, told, undecided(steps, final, len(final.guess.parameters)))
