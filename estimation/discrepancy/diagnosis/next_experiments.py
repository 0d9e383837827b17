"""What to record next: which effects are still open after the logs so far, the motion that tells them apart, and what
else would help, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cartgrasp.effects import ConstraintEffect, Effect, SensorEffect
from cartgrasp.effects.effect import Gate
from cartgrasp.effects.time_delay import TimeDelay
from cartgrasp.information import WrenchNoise

from ...experiments.proposal import Experiment, Proposal, Question
from ...experiments.separation import Belief, Hands
from ...weak_form.coordinates import jacobian
from ..findings.alternatives import alternatives
from ..search.candidates import amplitudes_of
from ..search.gains import CONFUSABLE_NATS, MIN_GAIN_NATS, added, every_family
from ..search.model import Model
from ..search.plausibility import MIN_NAMED_SIZE_RATIO, is_plausible

if TYPE_CHECKING:
    from .diagnosis import Diagnosis

MODEL_ERROR_FRACTION = 0.01
"""Share of the wrench by which a model is wrong, as in rows (`rows.py`)."""
MAX_LISTED_NAMES = 4
"""Most names in a sentence: so many are told, the rest is counted."""
INDISTINCT_SIGMAS = 0.05
"""Deviations: less rounds to nought."""
NOTHING_OPEN = "nothing is undecided that another motion would tell"


@dataclass(frozen=True, eq=False)
class NextExperiment:
    """What to run next, None where nothing is open, or where no motion tells; and what to do, in words, the most useful
    first."""

    proposal: Proposal | None
    words: tuple[str, ...]

    @property
    def why_none(self) -> str:
        """Why there is no motion to run; empty where there is one."""
        if self.proposal is not None:
            return ""
        return self.words[0] if self.words else NOTHING_OPEN


def next_experiment(found: Diagnosis) -> NextExperiment:
    """What to run next for what a diagnosis leaves open."""
    experiment = undecided(found)
    proposal, words = None, list[str]()
    if experiment is not None:
        log = found.final.logs[0].log
        start = np.round(log.pose[np.isfinite(log.pose).all(axis=1)][0], 3)
        whole = experiment.proposed(found.limits, start, max(float(b.log.time[-1]) for b in found.final.logs))
        apart, alone = _proposal_sigmas(whole)
        told = _proposal_words(whole, apart, alone) or _small_size_words(whole)
        proposal = whole if told else None
        words += [*told, *_undecided_words(apart, alone)]
    return NextExperiment(proposal, tuple(dict.fromkeys([*words, *_beside(found)])))


def undecided(found: Diagnosis) -> Experiment | None:
    """Pairs of carts between which the logs so far don't decide; None where there are none, or where nobody pushes."""
    hands = _hands(found)
    if not hands.contacts or not found.is_moved:
        return None
    final, beliefs, questions = found.final, list[Belief](), list[Question]()

    def add(model: Model) -> int:
        beliefs.append(_belief(model))
        return len(beliefs) - 1

    own = add(final)
    for effect, others in _alternatives(found):
        less = final.cart.without_effect(effect.key)
        known = [(one.key, add(final.refitted(less.with_effect(one)))) for one in others]
        for k, (name, place) in enumerate(known):
            questions += [Question(effect.key, name, own, place), Question(name, effect.key, place, own)]
            for other, beside in known[:k]:
                questions += [Question(name, other, place, beside, 0.5), Question(other, name, beside, place, 0.5)]
    for effect in _nearly_added(found):
        questions.append(Question(effect.key, "", add(final.refitted(final.cart.with_effect(effect))), own))
    usual = _usual_effects(found, {one.name.partition(".")[0] for one in questions})
    for effect, size, before in usual:
        cart = final.cart.with_effect(effect)
        beliefs.append(Belief(cart, np.zeros((len(cart.parameters), 0))))  # by nobody's fit
        questions.append(Question(effect.key, "", len(beliefs) - 1, own, 1.0 / len(usual), before, size))
    return Experiment(tuple(beliefs), tuple(questions), hands) if any(map(_is_open, questions)) else None


def _is_open(question: Question) -> bool:
    """Whether logs tell it, of usual size, by less than a name takes."""
    return question.size == 1.0 and _nats(question.before) < MIN_GAIN_NATS


def _belief(model: Model) -> Belief:
    """Belief of a fit: its cart, and what the rows and the prior leave open of the parameters."""
    free = model.prior.free
    covariance = model.score.covariance[: free.sum(), : free.sum()]
    return Belief(model.cart, jacobian(model.cart)[:, free] @ np.linalg.cholesky(covariance))


def _alternatives(found: Diagnosis) -> Iterator[tuple[Effect, list[Effect]]]:
    """Each effect that was added, with what explains about as much in its place."""
    left = {effect.key: effect for effect in added(found.final)}
    for step in found.steps:
        own = left.pop(step.added.key, None) if step.added else None
        known = [one.candidate for _, one in alternatives(step)] if own else []
        others = [one for one in known if isinstance(one, Effect) and _is_seen(one) and one.key not in left]
        if own and _is_seen(own) and others:
            yield own, others


def _nearly_added(found: Diagnosis) -> list[Effect]:
    """What the logs speak for, and was left out at the end, or withdrawn for what unseen stretches say."""
    last = found.steps[-1].attempts if found.steps and found.steps[-1].added is None else ()
    near = [step.added for step in found.steps if step.added is not None]
    near += [one for one in last if one.model is not None and one.gain > CONFUSABLE_NATS]
    effects = {one.key: one.candidate for one in near if isinstance(one.candidate, Effect)}
    has, wheels = {effect.key for effect in found.final.cart.effects}, found.final.cart.wheel_set
    return [e for key, e in effects.items() if key not in has and _is_seen(e) and is_plausible(e, wheels)]


def _usual_effects(found: Diagnosis, names: set[str]) -> list[tuple[Effect, float, float]]:
    """Effects but for some names, each with its size and the deviations by which the logs' motion shows it: of usual
    size (1), or, where the logs would show that, of the size that may be there unseen. Of variants, it is the middle
    one."""
    shown = {key: one.z for key, one in found.isolability.items()}
    late = [check.clock_offset.std for check in found.checks if check.clock_offset]
    shown[TimeDelay.name] = TimeDelay.parameters[0].typical / min(late) if late else 0.0
    known = [family for family in every_family(found.final) if family.key in shown]
    middle = [(family.variants[len(family.variants) // 2], shown[family.key]) for family in known]
    asked = [(e, undetected_size(e, z), z) for e, z in middle]
    fit = [one for one in asked if one[0].name not in names and one[0].gate is Gate.ALWAYS and _is_seen(one[0])]
    return [(_of_size(effect, size), size, size * z) for effect, size, z in fit]


def undetected_size(effect: Effect, z: float) -> float:
    """Which size of an effect, whose usual one shows by z deviations, may be there unseen."""
    if isinstance(effect, ConstraintEffect) or _nats(z) < MIN_GAIN_NATS:
        return 1.0
    return max(math.sqrt(2.0 * CONFUSABLE_NATS) / z, MIN_NAMED_SIZE_RATIO)


def _of_size(effect: Effect, size: float) -> Effect:
    """The effect of a share of its usual size."""
    if isinstance(effect, ConstraintEffect):
        return effect
    values = effect.values.copy()
    for i in amplitudes_of(effect):
        values[i] = effect.parameters[i].absent + size * effect.parameters[i].typical
    return effect.with_values(values)


def _is_seen(effect: Effect) -> bool:
    """Whether expected wrenches and speeds across the wheels tell what it does: not of a frame that is tracked."""
    return not (isinstance(effect, SensorEffect) and effect.moves_pose)


def _hands(found: Diagnosis) -> Hands:
    """Where the arms hold in the first log that has each, and the first log's noise."""
    logs = [balances.log for balances in found.final.logs]
    known = (
        (arm, own.contact[np.isfinite(own.contact).all(axis=1)]) for log in logs[::-1] for arm, own in log.arms.items()
    )
    contacts = {arm: np.median(points, axis=0) for arm, points in known if len(points)}
    check = found.checks[0]
    noise = WrenchNoise(check.noise.force, check.noise.moment, check.rate)
    return Hands(contacts, noise, check.noise.position, MODEL_ERROR_FRACTION)


def _nats(z: float) -> float:
    """Log of the likelihood ratio (nats) at so many deviations."""
    return z * z / 2.0


PairSigmas = dict[tuple[str, str], float]
"""Deviations by which two differ, whichever of them is true."""


def _proposal_words(proposal: Proposal, pairs: PairSigmas, alone: dict[str, float]) -> list[str]:
    """What the motion is for, what to do, and how well it tells; nothing where it tells nothing."""
    apart = list(dict.fromkeys(name for pair, z in pairs.items() if _nats(z) >= CONFUSABLE_NATS for name in pair))
    shown = [name for name, z in alone.items() if _nats(z) >= CONFUSABLE_NATS]
    goals = [f"to tell {_listed(apart, 'and')} apart"] if apart else []
    goals += [f"to see whether there is {_listed(shown, 'or')}"] if shown else []
    if not goals:
        return []
    least = min([z for z in pairs.values() if _nats(z) >= CONFUSABLE_NATS] + [alone[name] for name in shown])
    return [f"{', and '.join(goals)}: {proposal.says} (at least {least:.0f} standard deviations apart)"]


def _small_size_words(proposal: Proposal) -> list[str]:
    """What the motion is for where all that it shows is less than usual, and what to do."""
    asked = zip(proposal.questions, proposal.deviations, strict=True)
    little = [one.name for one, z in asked if one.size < 1.0 and _nats(z) >= CONFUSABLE_NATS]
    return [f"to see whether there is less than usual of {_listed(little, 'or')}: {proposal.says}"] if little else []


def _undecided_words(pairs: PairSigmas, alone: dict[str, float]) -> Iterator[str]:
    """What it leaves open."""
    for (one, other), z in pairs.items():
        if _nats(z) < CONFUSABLE_NATS:
            how = f"they differ by {z:.1f} deviations" if z > INDISTINCT_SIGMAS else "they act alike"
            yield f"no motion of this speed and length tells {one} from {other}: {how}"
    hidden = [name for name, z in alone.items() if _nats(z) < CONFUSABLE_NATS]
    if hidden:
        yield f"no motion of this speed and length shows {_listed(hidden, 'or')}"


def _proposal_sigmas(proposal: Proposal) -> tuple[PairSigmas, dict[str, float]]:
    """Deviations by which rivals differ, and by which what may be there, and didn't show before, shows."""
    pairs, alone = PairSigmas(), dict[str, float]()
    for one, z in zip(proposal.questions, proposal.deviations, strict=True):
        if one.other:
            pair = (one.name, one.other) if (one.other, one.name) not in pairs else (one.other, one.name)
            pairs[pair] = min(z, pairs.get(pair, z))
        elif _is_open(one):
            alone[one.name] = z
    return pairs, alone


def _listed(names: list[str], link: str) -> str:
    more = len(names) - MAX_LISTED_NAMES
    told = [*names[:MAX_LISTED_NAMES], f"{more} more"] if more > 1 else names
    return f" {link} ".join((", ".join(told[:-1]), told[-1])[len(told) < 2 :])


def _beside(found: Diagnosis) -> Iterator[str]:
    """What no other motion alone would do."""
    if not found.is_moved or not _hands(found).contacts:
        yield f"push the cart: {'nobody does' if found.is_moved else 'nothing moves'} in these logs"
    for effect in found.effects:
        if effect.name in effect.confusable_with:
            yield f"push with one arm alone, then with another: that tells whose {effect.name} it is"
    for law in (*found.final.laws, *found.may_follow)[:1]:
        other = "begin the same motion later" if law.name == "time" else f"repeat the motion with another {law.name}"
        yield f"{other}, to see whether the force follows {'the clock' if law.name == 'time' else 'it'}"
    if found.verdict in ("unexplained", "partly_explained"):
        yield "record the same motion twice: what comes back is the cart's, what does not is noise"
