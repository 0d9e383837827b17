"""Which effects logs' model lacks: by one score, added one at a time, and dropped where they are worth nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from cartgrasp.effects import Effect
from cartgrasp.effects.effect import Gate
from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ...weak_form.balances import Balances
from ...weak_form.wheel_tracks import leaves
from .backward_elimination import pruned, retuned
from .continuum import beside_neighbours
from .form_error import FormError
from .gains import (
    CONFUSABLE_NATS,
    GAIN_SIGMAS,
    MIN_GAIN_NATS,
    added,
    added_score_gain,
    every_family,
    margin,
    score_gain,
    scored_candidate,
    standard_error,
    variance_inflation_of,
    without_amplitudes,
)
from .laws import Law
from .model import FORCE_LEVER_STD, Model
from .periods import is_like_a_scans
from .plausibility import ESSENTIAL_PARAMETERS, ESSENTIAL_SIGMAS, MOMENT_BY_FORCE, PRIOR_LOG_ODDS, is_plausible
from .refine import refined
from .scored_candidates import Refit, ScoredCandidate, SearchStep
from .screening import MIN_CHANGE_MARGIN, Screen

MIN_GAIN_FRACTION = 0.05
"""Least share of the largest gain so far. What gains less beside the forms of others (`form_error.py`) may be a form
that nobody thought of, unless it is one of `UBIQUITOUS_EFFECTS`."""
REFINED_GAIN_FRACTION, MAX_REFITTED_EFFECTS, MAX_REFITTED_LAWS = 0.3, 5, 2
"""Candidates that are refined and refitted: least share of the best gain, and most of the vocabulary and beside it."""
MIN_RESIZING_NATS = 2.0
"""Least gain in score of another size of an effect of the file."""
MAX_SEARCH_STEPS, MAX_SWAPPED_EFFECTS = 6, 2


ClosesGap = Callable[[Model, Model], bool]
"""Whether a model closes most of what another leaves on stretches that it did not see."""


def search(model: Model, tell: Callable[[str], None], closes: ClosesGap) -> tuple[Model, list[SearchStep]]:
    """The model with all that is worth it, and what was tried on the way."""
    nominal = replace(model, compares=True).rewhitened()
    model, steps = simplified(*named_instead(*_forward_selection(nominal, tell, closes), tell, closes))
    return replace(resized(model), compares=False).settled(), steps


def named_instead(
    model: Model, steps: list[SearchStep], tell: Callable[[str], None], closes: ClosesGap
) -> tuple[Model, list[SearchStep]]:
    """The model with names in place of laws, where they explain about as much."""
    if not model.laws:
        return model, steps
    bare = replace(model, laws=()).refitted(model.cart)
    named, others = _forward_selection(bare, tell, closes, len(model.laws), _first(steps), has_laws=False)
    alike = replace(model, laws=()).refitted(named.cart)
    if score_gain(alike.score, model.score, None) > margin(alike, model):
        return model, steps
    kept = (step for step in steps if step.added is None or not isinstance(step.added.candidate, Law))
    return named, [*kept, *others]


def _forward_selection(
    model: Model,
    tell: Callable[[str], None],
    closes: ClosesGap,
    most: int = MAX_SEARCH_STEPS,
    first: float = 0.0,
    has_laws: bool = True,
) -> tuple[Model, list[SearchStep]]:
    """The model with candidates added, so many at most, as long as they are worth it beside what gained most so far."""
    steps = list[SearchStep]()
    for number in range(most):
        tell(f"looking for what is missing, step {number + 1}")
        attempts = ranked_candidates(model, has_laws)
        form_error = MIN_GAIN_FRACTION * first
        best = chosen(attempts, form_error, MIN_GAIN_NATS) or _closing(attempts, model, closes)
        steps.append(SearchStep(tuple(attempts), best, form_error))
        if best is None or best.model is None:
            break
        first = max(first, _first(steps))
        more = retuned(replace(best.model, compares=False).rewhitened())
        more = pruned(replace(more, compares=True).rewhitened(), MIN_GAIN_NATS).settled()
        if structure_keys(more) == structure_keys(model):
            break
        model = more
    return model, steps


def _first(steps: list[SearchStep]) -> float:
    """What an effect or a law gained at most."""
    found = (step.added for step in steps if step.added is not None)
    return max((one.gain for one in found if not isinstance(one.candidate, Refit)), default=0.0)


def simplified(model: Model, steps: list[SearchStep]) -> tuple[Model, list[SearchStep]]:
    """The model with simpler effects in place of added ones, where they explain about as much beside all else. So, too,
    for those that are no longer what their name says. Alone, what takes more numbers may have stood in for two."""
    if len(added(model)) + len(model.laws) < 2:
        return model, steps
    for effect in added(model):
        less = model.refitted(model.cart.without_effect(effect.key))
        own = ScoredCandidate(effect, added_score_gain(less, model, effect), 1, model)
        others = (e for family in every_family(less) for e in family.variants)
        simpler = [e for e in others if e.gate is Gate.ALWAYS and len(e.parameters) < own.numbers]
        near = sorted((scored_candidate(less, e, 1) for e in simpler), key=lambda one: -one.gain)[:MAX_SWAPPED_EFFECTS]
        found = [_beside(less, one.candidate) for one in near if isinstance(one.candidate, Effect)]
        best = max((one for one in found if is_eligible(one)), key=lambda one: one.gain, default=own)
        if best is own or best.model is None or best.gain < MIN_GAIN_NATS:
            continue
        if not is_eligible(own) or own.gain - best.gain <= margin(best.model, model, effect.gate):
            model, steps = best.model, [_swapped_step(step, best, own) for step in steps]
    return model, steps


def _beside(model: Model, effect: Effect) -> ScoredCandidate:
    """An effect that acts all the time, fitted with all else."""
    new = model.refitted(model.cart.with_effect(effect))
    found = next(one for one in new.cart.effects if one.key == effect.key)
    return ScoredCandidate(found, score_gain(model.score, new.score, None), 1, new)


def _swapped_step(step: SearchStep, best: ScoredCandidate, own: ScoredCandidate) -> SearchStep:
    """The step that added what now is the rival of another."""
    if step.added is None or step.added.key != own.key:
        return step
    rest = (one for one in step.attempts if one.key not in (best.key, own.key))
    return SearchStep((best, own, *rest), best, step.form_error)


def structure_keys(model: Model) -> set[str]:
    """Keys of all that a model has beside the guess, and of what may have any size."""
    return {effect.key for effect in added(model)} | {law.key for law in model.laws} | model.wide


def resized(model: Model) -> Model:
    """The model with effects of the file at other sizes than it says, where the logs do: that names nothing."""
    for effect in model.guess.effects:
        if effect.key not in model.wide and any(p.estimated for p in effect.parameters):
            new = replace(model, wide=model.wide | {effect.key}).refitted(model.cart)
            if score_gain(model.score, new.score, None) > MIN_RESIZING_NATS:
                model = new
    return model


def ranked_candidates(model: Model, has_laws: bool) -> list[ScoredCandidate]:
    """All candidates, with laws or without, the most worth first; the best few refitted."""
    screen, found = Screen(model), []
    for family in every_family(model):
        best, count = screen.best(family)
        own = [one for effect in best if np.isfinite((one := scored_candidate(model, effect, count)).gain)]
        if own:
            found.append(max(own, key=lambda one: one.gain))
    for effect in model.guess.effects:
        if effect.key not in model.wide and any(p.estimated for p in effect.parameters):
            new = replace(model, wide=model.wide | {effect.key}).refitted(model.cart)
            gain, error = score_gain(model.score, new.score, None), standard_error(model.score, new.score)
            found.append(ScoredCandidate(Refit(effect), gain, 1, new, error))
    for law, count in screen.laws() if has_laws else ():
        score = model.with_columns(model.whitened([law.columns(b, model.cart) for b in model.logs]), law.std)
        found.append(ScoredCandidate(law, score_gain(model.score, score, None) - np.log(count), count))
    found.sort(key=lambda one: -one.gain)
    enough = max(REFINED_GAIN_FRACTION * found[0].gain, MIN_GAIN_NATS / 2)
    names = [one for one in found if not isinstance(one.candidate, Law)][:MAX_REFITTED_EFFECTS]
    laws = _simplest([one for one in found if isinstance(one.candidate, Law)])[:MAX_REFITTED_LAWS]
    forms = FormError(model) if added(model) or model.laws else None
    near = [refitted_candidate(model, screen, one, forms) for one in (*names, *laws) if one.gain > enough]
    rest = [one for one in found if one.key not in {n.key for n in near}]
    return sorted(near, key=lambda one: -one.gain) + rest


def _simplest(laws: list[ScoredCandidate]) -> list[ScoredCandidate]:
    """The simplest law of each variable and way of acting that explains about as much as the best."""
    groups = dict[tuple[Any, ...], list[ScoredCandidate]]()
    for one in laws:
        assert isinstance(one.candidate, Law)
        groups.setdefault(one.candidate.kind, []).append(one)
    alike = ([one for one in group if group[0].gain - one.gain <= CONFUSABLE_NATS] for group in groups.values())
    return sorted((min(group, key=lambda one: one.numbers) for group in alike), key=lambda one: -one.gain)


def chosen(attempts: list[ScoredCandidate], form_error: float, least: float) -> ScoredCandidate | None:
    """The simplest attempt that is not surely worth less than the best that somebody would call so (Breiman's rule of
    one standard error). Only those count that are worth it, and more than what the form of others may have left."""
    known = [one for one in attempts if one.model and is_eligible(one)]
    known = [one for one in known if one.own_gain >= min_gain(one, form_error, least) and one.repeats(least)]
    best = max(known, key=lambda one: one.gain, default=None)
    alike = [one for one in known if best is not None and best.gain - one.gain <= _margin(one, best)]
    return min(alike, key=lambda one: (one.numbers, -one.gain), default=None)


def _closing(attempts: list[ScoredCandidate], model: Model, closes: ClosesGap) -> ScoredCandidate | None:
    """What acts all the time and gains less, where it closes most of the gap on stretches that no fit saw: what drifts
    is cheap beside noise with a long memory, and adds up in rollouts."""
    best = chosen([one for one in attempts if one.error], 0.0, CONFUSABLE_NATS)
    return best if best is not None and best.model is not None and closes(model, best.model) else None


def min_gain(one: ScoredCandidate, form_error: float, least: float) -> float:
    """Least gain of an attempt: more than the form of others may have left, unless it is usual."""
    return least if one.is_usual else max(least, form_error)


def _margin(one: ScoredCandidate, best: ScoredCandidate) -> float:
    """How much less than the best a candidate may explain. For a name beside a law, whose form fits more, it is at
    least what forms may leave."""
    assert one.model is not None
    assert best.model is not None
    is_form = isinstance(best.candidate, Law) and not isinstance(one.candidate, Law)
    by_chance = margin(one.model, best.model, one.gate, best.gate)
    return max(by_chance, MIN_GAIN_FRACTION * best.gain if is_form else 0.0)


def is_eligible(one: ScoredCandidate) -> bool:
    """Whether somebody who knows carts would call a fitted attempt so, and stretches are sure of its gain."""
    if one.gain < GAIN_SIGMAS * one.error:
        return False
    assert one.model is not None
    if isinstance(one.candidate, Refit | Law):
        return True
    return is_plausible(one.candidate, one.model.cart.wheel_set) and not missing_evidence(one.candidate, one.model)


def missing_evidence(effect: Effect, model: Model) -> str:
    """What logs lack to tell an effect from a simpler one, in words; empty where nothing."""
    if effect.gate is Gate.INSIDE:
        outside = (_time_outside(effect.values[:4], model.cart, balances) for balances in model.logs)
        if sum(outside) < MIN_CHANGE_MARGIN:
            return f"no wheel was outside for {MIN_CHANGE_MARGIN:g} s"
    name = ESSENTIAL_PARAMETERS.get(effect.name, "")
    if not name:
        return ""
    values, key = dict(zip(effect.keys, effect.values.tolist(), strict=True)), f"{effect.key}.{name}"
    moment, force = MOMENT_BY_FORCE.get(effect.name, ("", ""))
    beside = FORCE_LEVER_STD * abs(values[f"{effect.key}.{force}"]) if name == moment else 0.0
    if abs(values[key]) <= ESSENTIAL_SIGMAS * float(np.hypot(model.deviation(key), beside)):
        return f"its {name} is within {ESSENTIAL_SIGMAS:g} standard deviations of nought"
    return ""


def _time_outside(region: Array, cart: CartModel, balances: Balances) -> float:
    """How long (s) a cart moved with a wheel outside of a region (x, x, y, y) of the floor."""
    motion, moves = balances.motion, balances.turning_speed > balances.still_speed
    return float((leaves(motion.pose, region, cart.wheel_set) & moves).sum() * motion.step)


def refitted_candidate(model: Model, screen: Screen, one: ScoredCandidate, forms: FormError | None) -> ScoredCandidate:
    """Candidate with its settings where they are best, and fitted with all else; beside the forms of a model's effects,
    too."""
    if isinstance(one.candidate, Refit):
        return one
    found: Effect | Law
    if isinstance(one.candidate, Law):
        found = screen.tuned(one.candidate)
        new = replace(model, laws=(*model.laws, found)).refitted(model.cart)
    else:
        best = refined(without_amplitudes(one.candidate), screen.gain)
        effect = scored_candidate(model, best, one.tried).candidate
        assert not isinstance(effect, Law | Refit)
        new = model.refitted(model.cart.with_effect(effect))
        found = next(e for e in new.cart.effects if e.key == effect.key)
    colour = variance_inflation_of(new, found)
    before = PRIOR_LOG_ODDS.get(found.name, 0.0) if isinstance(found, Effect) else 0.0
    before -= float(np.log(one.tried))
    gain = before + score_gain(model.score, new.score, colour)
    error = standard_error(model.score, new.score) if colour is None else 0.0
    beside = None if forms is None else before + score_gain(*forms.scores(new, found), colour)
    is_once = isinstance(found, Effect) and new.acts_once(found)
    drifting = before + score_gain(model.score, new.score, new.variance_inflation) if is_once else None
    wandering = None
    if isinstance(found, Law) and is_like_a_scans(found.effects[0]):
        wandering = before + beside_neighbours(new, found)
    return ScoredCandidate(found, gain, one.tried, new, error, beside, drifting, wandering)
