"""What of an extended model holds on stretches that it did not see."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from cartgrasp.errors import UsageError
from cartgrasp.inertia import N_PHI

from ...weak_form.band import INERTIAL_EFFECTS, Band, pooled
from ...weak_form.coordinates import coordinates, with_coordinates
from ...whole_log.corrected_fit import CorrectedFit, corrected
from ..log_check import moves
from ..search.gains import added
from ..search.laws import Law
from ..search.model import Model
from ..search.plausibility import ESSENTIAL_SIGMAS, PRIOR_LOG_ODDS
from ..search.scored_candidates import SearchStep
from .alternatives import between_model_covariance
from .certainty import Certainty
from .gap import DISAGREEMENT_NOISE_RATIO
from .held_out import file_rollouts, floor_rollouts, held_out_rollouts
from .refusal import MAX_REFIT_ERROR_RATIO, is_beyond
from .rollouts import Rollouts

MIN_GAP_CLOSED_FRACTION = 0.8
"""Share of the squared gap above noise: what closes as much is told though it gains less than `MIN_GAIN_NATS`."""


def validated(final: Model, nominal: Model, known: Sequence[Band | None]) -> tuple[Model, tuple[Law, ...]]:
    """The model without what does not hold, and the laws that were withdrawn. First go loads that what nobody recorded
    may look like. Then go laws without which unseen stretches are foretold better. That these are hardly better with it
    is no reason: rows tell what is fast by many nats, and rollouts, which add up, next to nothing of it. Last additions
    go while unseen stretches are predicted no better with them than by what is known, or refitted, and surely farther
    off than noise."""
    final = without(final, within_bracket(final, known))
    laws = final.laws
    if not (laws or added(final)):
        return final, ()
    best = _known_error(nominal)
    floor, error = rollout_error(floor_rollouts(final)), rollout_error(held_out_rollouts(final))
    for law in laws:
        less = replace(final, laws=tuple(one for one in final.laws if one is not law)).refitted(final.cart).settled()
        bare = rollout_error(held_out_rollouts(less))
        if bare < error:
            final, error = less, bare
    while (final.laws or added(final)) and error >= max(_most(final, best), floor) and is_beyond(final, floor):
        cart = final.cart if final.laws else final.cart.without_effect(added(final)[-1].key)
        final = replace(final, laws=final.laws[:-1]).refitted(cart).settled()
        error = rollout_error(held_out_rollouts(final))
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
    most = ESSENTIAL_SIGMAS * share * final.cart.inertia.mass
    loads = [effect for effect in added(final) if effect.name in INERTIAL_EFFECTS]
    return [e.key for e in loads if abs(e.values[e.keys.index(f"{e.key}.mass")]) < most]


def _most(final: Model, best: float) -> float:
    """Error from which on stretches speak against what was added last. Against what every cart has, they speak only
    where they are predicted worse."""
    return best if final.laws or added(final)[-1].name not in PRIOR_LOG_ODDS else MAX_REFIT_ERROR_RATIO * best


def closes_most(less: Model, more: Model) -> bool:
    """Whether a model closes most of what another leaves, if that is beyond noise, on stretches that it did not see."""
    floor = rollout_error(floor_rollouts(more))
    best = _known_error(less)
    if best <= DISAGREEMENT_NOISE_RATIO * floor:
        return False
    left = rollout_error(held_out_rollouts(more))
    return left**2 - floor**2 < (1.0 - MIN_GAP_CLOSED_FRACTION) * (best**2 - floor**2)


def _known_error(model: Model) -> float:
    """Rollout error (m) of the cart as it is believed, or of the model where that foretells better."""
    return min(rollout_error(file_rollouts(model)), rollout_error(held_out_rollouts(model)))


def rollout_error(rolled: Rollouts) -> float:
    """Rollout error (m) after a second; infinite where none goes so far."""
    return float(np.nan_to_num(rolled.gaps()[1], nan=np.inf)) if len(rolled.error) else np.inf


def certainty_of(final: Model, steps: Sequence[SearchStep], known: Sequence[Band | None]) -> Certainty:
    """Certainty of a model with the bands `known` of its logs."""
    told = tuple(band for band in known if band is not None)
    beside = between_model_covariance(steps, final, len(final.guess.parameters))
    return Certainty(final, told, beside, _corrected(final))


def _corrected(final: Model) -> CorrectedFit | None:
    """The model without what noise in the motion does to it; None of logs at rest, of which nothing was fitted. Where
    no cart is found that stays, CoM and inertia are as unsure as they are believed to be."""
    if not any(map(moves, final.logs)):
        return None
    try:
        with np.errstate(all="ignore"):  # what runs away does not settle
            found = corrected(_of_guessed_body(final))
    except (UsageError, np.linalg.LinAlgError):
        found = None
    if found is not None and found.is_settled:
        return found
    body = np.arange(len(final.prior.free))
    unsure = np.where((body > 0) & (body < N_PHI), final.prior.std, 0.0)[final.prior.free]
    return CorrectedFit(final, np.diag(unsure**2), np.zeros(len(unsure)), np.zeros(len(body), dtype=bool), False)


def _of_guessed_body(model: Model) -> Model:
    """The model at the CoM, and the inertia per mass, of its first guess: to where noise in the motion has pulled a
    body, rows that are made linear tell it too well."""
    z, first = coordinates(model.cart), coordinates(model.guess)
    first[3] += z[0] - first[0]
    own = np.flatnonzero(model.prior.free[1:N_PHI]) + 1
    z[own] = first[own]
    return replace(model, cart=with_coordinates(model.cart, z))
