"""Why each candidate of a step of the search was added, or was not, in words that tell the rule and its numbers."""

from __future__ import annotations

from collections.abc import Sequence

from cartgrasp.effects import Effect

from ..search.gains import GAIN_SIGMAS, MIN_GAIN_NATS
from ..search.laws import Law
from ..search.model import Model
from ..search.plausibility import PRIOR_LOG_ODDS, objection
from ..search.scored_candidates import Refit, ScoredCandidate, SearchStep
from ..search.search import is_eligible, min_gain, missing_evidence

ADDED, OTHER_SIZE = "added", "given another size"
WITHDRAWN = "added, and withdrawn: beside all else, or on unseen stretches, too little speaks for it"
FORM_ERROR_WORDS = "what the forms of others may leave"
NOT_FITTED = "not fitted with all else: too many others gain more at first sight"


def verdict(step: SearchStep, one: ScoredCandidate, final: Model | None = None) -> str:
    """Verdict on one of a step's attempts; with the model in the end, whether what was added was kept."""
    if one is step.added:
        return ADDED if final is None else _kept(one, final)
    if one.own_gain < (least := min_gain(one, step.form_error, MIN_GAIN_NATS)):
        rest = "noise that drifts as what is left" if one.own_gain == one.beside_drift else FORM_ERROR_WORDS
        beside = "" if one.own_gain >= one.gain else f", {one.own_gain:.1f} beside {rest}"
        why = " beside what gained most" * (least > MIN_GAIN_NATS)
        return f"gains {round(one.gain, 1) + 0.0:.1f} nats{beside}, and {least:.1f} are needed{why}"
    if not one.repeats(MIN_GAIN_NATS):
        gained = f"gains {one.beside_neighbours:.1f} nats beside noise that wanders about its period"
        return f"{gained}, and {MIN_GAIN_NATS:g} are needed"
    if one.gain < GAIN_SIGMAS * one.error:
        return (
            f"gains less than {GAIN_SIGMAS:g} standard deviations of its gain: from stretch to stretch it is not sure"
        )
    if odd := _objection(one):
        return odd
    return NOT_FITTED if step.added is None else _beside(one, step.added)


def may_follow(steps: Sequence[SearchStep]) -> tuple[Law, ...]:
    """The law that gained most in the end, and was refused for nothing but what the forms of others may make."""
    last = steps[-1].attempts if steps and steps[-1].added is None else ()
    near = [one for one in last if one.model is not None and one.gain >= MIN_GAIN_NATS][:1]
    return tuple(one.candidate for one in near if isinstance(one.candidate, Law) and is_eligible(one))


def _kept(one: ScoredCandidate, final: Model) -> str:
    if isinstance(one.candidate, Law):
        return ADDED if any(law.kind == one.candidate.kind for law in final.laws) else WITHDRAWN
    if isinstance(one.candidate, Refit):
        return OTHER_SIZE
    return ADDED if one.key in {effect.key for effect in final.cart.effects} else WITHDRAWN


def _objection(one: ScoredCandidate) -> str:
    """Why nobody would call it so at its values; empty where somebody would, or where it was not fitted."""
    if one.model is None or isinstance(one.candidate, Refit | Law):
        return ""
    return objection(one.candidate, one.model.cart.wheel_set) or missing_evidence(one.candidate, one.model)


def _beside(one: ScoredCandidate, added: ScoredCandidate) -> str:
    """Why it lost against what was added."""
    less, more = round(added.gain, 1) - round(one.gain, 1), one.numbers - added.numbers
    usual = PRIOR_LOG_ODDS.get(added.candidate.name, 0.0) - PRIOR_LOG_ODDS.get(one.candidate.name, 0.0)
    if one.model is None and less <= 0:
        return NOT_FITTED
    if less <= 0:
        return f"gains {-less:.1f} nats more than {added.key} by {more} number{'s' * (more != 1)} more: not surely more"
    if usual > 0 and less <= usual and isinstance(one.candidate, Effect):
        return f"gains {less:.1f} nats less than {added.key}, which is likelier beforehand by {usual:g}"
    return f"gains {less:.1f} nats less than {added.key}"
