"""Which effects a model lacks: one added at a time, the most probable, for as long as one is worth it.

An effect is named with evidence, and a gain on stretches that no fit saw, and amplitudes of a sign and size that it can
have. At the end, what later ones have made superfluous is taken out.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.special import logsumexp

from cartgrasp.effects import ConstraintEffect, Effect, SensorEffect
from cartgrasp.effects.effect import Gate
from cartgrasp.model import CartModel

from ..batch.wrench_regression import WrenchRegression
from .bent_motion import bent, on_moving_rows, with_its_noise
from .dictionary import Dictionary
from .evidence import Finding, findings
from .fitted import Fitted
from .held_out import HeldOut
from .isolability import Isolability, isolability
from .judgement import (
    ADDED,
    ENOUGH,
    LEAST_GAIN,
    UNSTEADY,
    Judge,
    Verdict,
)
from .onset import with_best_onset
from .pruning import NEARLY, pruned, still_plausible
from .refinement import Refiner, searched_again
from .sideways import sideways_trials
from .stand_ins import stand_ins
from .vocabulary import trials

MOST_TRIED = 4
"""Effects that are fitted at every step."""
WORTH_TRYING = 3.0
"""Log of a Bayes factor: below it nobody looks closer."""
HOPELESS = 0.25
"""Of the best one's: what screens below it does not win by refinement."""
IN_VOCABULARY = 0.95
"""How often what is missing is of the vocabulary, and of a form near enough to ours."""
IMPLAUSIBLE = "not plausible"
NOT_TOLD_APART = 4.6
"""Difference of logs of Bayes factors: a hundredth."""
MOST_BY_REFIT = 2.0
"""Times what the linear fit gains, or a share of it: more is a better fit of all else, less a form that has no weight
there."""
MOST_EFFECTS = 4
UNSETTLES = 0.1
"""Of the log of the Bayes factor of what is there and has no name: a second effect that explains less is not what makes
it look unsteady."""


@dataclass(frozen=True)
class Attempt:
    """An effect tried at a step: the log of its Bayes factor, and what it gains on held-out stretches, as a share of
    the gap above the noise floor that the refitted nominal model had. `verdict` says why it won or lost; `is_there`
    that it lost for its name alone: something is there, and it is not this."""

    key: str
    name: str
    log_factor: float
    held_out_gain: float | None
    verdict: str
    is_there: bool = False


@dataclass(frozen=True)
class Step:
    """One round: what was tried, and which was added, if any."""

    attempts: tuple[Attempt, ...]
    added: Attempt | None
    confusable: tuple[str, ...] = ()
    probability: float = 1.0

    def beside(self, shown: dict[str, Isolability]) -> Step:
        """With the effects that look like the added one on this motion, where they explain nearly as much."""
        if self.added is None or self.added.key not in shown:
            return self
        alike, least = shown[self.added.key].alike, NEARLY * self.added.log_factor
        near = [a.name for a in self.attempts if a.key in alike and a.log_factor > least and a.verdict != IMPLAUSIBLE]
        return self._confused(near)

    def instead_of(self, replaced: Sequence[tuple[str, str]]) -> Step:
        """With the names of effects that went, and would do nearly as well in place of the added one."""
        return self._confused([name for key, name in replaced if self.added is not None and self.added.key == key])

    def _confused(self, near: Sequence[str]) -> Step:
        """With other names; that another arm may have the same effect is told by its label."""
        own = self.added.name if self.added is not None else ""
        names = dict.fromkeys((*self.confusable, *near))
        return replace(self, confusable=tuple(name for name in names if name != own))


@dataclass(frozen=True)
class Selection:
    """The structure with none added, that with all, the steps between, and the judge of gaps; the keys of what was
    added and, beside what came later, not needed any more; what the motion could show; of what was removed, what has no
    name."""

    nominal: Fitted
    final: Fitted
    steps: tuple[Step, ...]
    held_out: HeldOut
    removed: tuple[str, ...]
    isolability: dict[str, Isolability]
    nameless: tuple[str, ...] = ()


def select(
    whole: Sequence[WrenchRegression], cart: CartModel, arms: Sequence[str], tell: Callable[[str], None]
) -> Selection:
    """From regressions of every log on the cart's smoothed motion."""
    tell("looking sideways")
    whole, fitted, steps = _sideways(whole, cart)
    whole, fitted = with_its_noise(whole, fitted)
    nominal = fitted if not steps else Fitted(fitted.regressions, cart)
    search = _Search(HeldOut(nominal, whole), arms, tell)
    strongest, shown = _creeping(fitted, steps), dict[str, Isolability]()
    while len(steps) < MOST_EFFECTS:
        tell(f"step {len(steps) + 1}: screening")
        look = search.look(fitted, strongest)
        shown = shown or isolability(look.dictionary, fitted.loose)
        if look.better is None and len(steps) + 1 < MOST_EFFECTS:
            look = search.beside_another(look, strongest) or look
        steps.append(look.step.beside(shown))
        if look.better is None or look.step.added is None:
            break
        fitted = still_plausible(searched_again(look.better, look.better.added[:-1], look.judge.is_odd), look.judge)
        strongest = max(strongest, look.step.added.log_factor)
    fitted, replaced = pruned(fitted, search.held_out)
    nameless = tuple[str, ...]()
    while lost := stand_ins(fitted, search.held_out):
        fitted, nameless = fitted.without_all(lost), (*nameless, *lost)
    kept = {effect.key for effect in fitted.added}
    steps = [step.instead_of(replaced) for step in steps]
    removed = tuple(step.added.key for step in steps if step.added is not None and step.added.key not in kept)
    return Selection(nominal, fitted, tuple(steps), search.held_out, removed, shown, nameless)


class _Look(NamedTuple):
    """A step from a fit: the model with what is added, if anything; that with the most probable effect which lost for
    its name alone, if one did."""

    judge: Judge
    dictionary: Dictionary
    step: Step
    better: Fitted | None
    nameless: Fitted | None


@dataclass(frozen=True)
class _Search:
    """Over the vocabulary, beside any fit."""

    held_out: HeldOut
    arms: Sequence[str]
    tell: Callable[[str], None]

    def look(self, fitted: Fitted, strongest: float) -> _Look:
        judge = Judge(fitted, self.held_out, strongest)
        dictionary = fitted.dictionary([one for one in trials(fitted.cart, self.arms) if judge.may_be(one)])
        return _step(fitted, dictionary, judge, self.tell)

    def beside_another(self, look: _Look, strongest: float) -> _Look | None:
        """Of two effects neither may have its name while the other is left out: the one that is added beside the
        nameless one, where that is then added beside it."""
        if look.nameless is None:
            return None
        self.tell("trying two at once")
        second = self.look(look.nameless.settled(), strongest)
        if second.better is None or second.step.added is None:
            return None
        whole = next(a.log_factor for a in look.step.attempts if a.key == look.nameless.added[-1].key)
        if second.step.added.log_factor < UNSETTLES * whole:
            return None
        alone = look.judge.fitted.tried(second.better.added[-1]).settled()
        again = self.look(alone, strongest)
        if again.step.added is None or again.step.added.key != look.nameless.added[-1].key:
            return None
        return look._replace(step=second.step, better=alone)


def _sideways(
    whole: Sequence[WrenchRegression], cart: CartModel
) -> tuple[tuple[WrenchRegression, ...], Fitted, list[Step]]:
    """Constraint effects, which bend the smoothed motion, come first; with each, the motion is smoothed again."""
    whole, steps = tuple(whole), list[Step]()
    added, fastest = tuple[Effect, ...](), 0.0
    while True:
        fitted = on_moving_rows(whole, cart, added)
        trials = sideways_trials(whole, fitted.cart)
        if not trials or not trials[0].is_worth(ENOUGH, LEAST_GAIN, fastest):
            return whole, fitted, steps
        added, fastest = (*added, trials[0].finding.effect), max(fastest, trials[0].speed)
        for _ in added:  # the new one, and each that came before it once more beside it
            whole, last = bent(whole, cart, added[:-1], added[-1])
            added = (last, *added[:-1])
        attempts = [
            Attempt(t.finding.effect.key, t.finding.effect.name, t.finding.log_factor, t.held_out_gain, "less probable")
            for t in trials
        ]
        attempts[0] = replace(attempts[0], verdict="added")
        near = tuple(a.name for a in attempts[1:] if attempts[0].log_factor - a.log_factor < NOT_TOLD_APART)
        steps.append(Step(tuple(attempts), attempts[0], near, IN_VOCABULARY))


def _creeping(fitted: Fitted, steps: Sequence[Step]) -> float:
    """The log of the Bayes factor of wheels that creep: their tyres have other forms, as an angle has not."""
    creep = {effect.key for effect in fitted.added if isinstance(effect, ConstraintEffect) and effect.slip_compliance}
    return max((s.added.log_factor for s in steps if s.added and s.added.key in creep), default=0.0)


@dataclass(frozen=True)
class _Tried:
    """An effect where it fits best, half the chi-squared that it takes away there by the linear fit, and the model with
    it."""

    effect: Effect
    gain: float
    model: Fitted

    @cached_property
    def left(self) -> float:
        """Chi-squared of the model, be the effect of our form or of another."""
        every = {effect.key for effect in self.model.added}
        return min(self.model.chi_squared(keys) for keys in (every - {self.effect.key}, every))


def _step(fitted: Fitted, dictionary: Dictionary, judge: Judge, tell: Callable[[str], None]) -> _Look:
    screened = findings(dictionary, fitted.loose)
    refiner = Refiner(fitted, judge.is_odd)

    def tried(finding: Finding) -> _Tried:
        tell(f"trying {finding.effect.name}")
        effect, gain = refiner.refined(finding.effect, finding.amplitudes, finding.prior_std)
        return _Tried(effect, gain.value, fitted.tried(effect))

    least = max(WORTH_TRYING, HOPELESS * screened[0].log_factor) if screened else 0.0
    candidates = [tried(one) for one in screened[:MOST_TRIED] if one.log_factor >= least]
    scored, again = _scored(fitted, dictionary, candidates)
    least = max([ENOUGH, *(HOPELESS * score for score, _, _ in scored)])
    known = {one.effect.key for one in candidates}
    rest = [one for key, one in again.items() if key not in known]
    late = -np.inf if fitted.is_late else WORTH_TRYING
    missed = [one for one in rest if one.log_factor >= (late if _is_late(one.effect) else least)][:MOST_TRIED]
    if missed:
        scored, again = _scored(fitted, dictionary, candidates + [tried(one) for one in missed])
    attempts, better, nameless = _judged(scored, again, judge)
    added = next((a for a in attempts if a.verdict == ADDED), None)
    rest = [f for f in again.values() if f.effect.key not in {a.key for a in attempts}]
    attempts += [Attempt(f.effect.key, f.effect.name, f.log_factor, None, "not probable enough") for f in rest]
    if added is None or better is None:
        return _Look(judge, dictionary, Step(tuple(attempts), None), None, nameless)
    left = [a for a in attempts[attempts.index(added) :] if a.verdict != IMPLAUSIBLE]
    logs = np.array([a.log_factor for a in left])
    probability = IN_VOCABULARY * float(np.exp(added.log_factor - logsumexp(np.append(logs, 0.0))))
    near = [a.name for a in left if a.name != added.name and added.log_factor - a.log_factor < NOT_TOLD_APART]
    step = Step(tuple(attempts), added, tuple(dict.fromkeys(near)), probability)
    return _Look(judge, dictionary, step, better, nameless)


def _judged(
    scored: Sequence[tuple[float, Effect, Fitted]], again: Mapping[str, Finding], judge: Judge
) -> tuple[list[Attempt], Fitted | None, Fitted | None]:
    """What comes of each, the most probable first; the model with the one that is added, if any, and with the first
    that is nameless."""
    attempts: list[Attempt] = []
    better, nameless, unproven = None, 0.0, 0.0
    unnamed: Fitted | None = None
    for score, effect, model in scored:
        if better is None and score < nameless:  # it explains less of a thing that has no name
            verdict = Verdict(False, "less probable than what has no name")
        elif better is None and score < unproven and effect.gate.ends:
            verdict = Verdict(False, "less probable than what is not proven, and lasts")
        elif better is None:
            verdict = judge.verdict(again[effect.key], score, model)
            if effect.gate is Gate.FROM and (verdict.is_added or verdict.is_unproven):
                model = with_best_onset(judge.fitted, model)
                verdict = judge.verdict(again[effect.key], score, model)
            if verdict.is_nameless and unnamed is None:
                nameless, unnamed = score, model
            unproven = max(unproven, score) if verdict.is_unproven and effect.gate is Gate.ALWAYS else unproven
        else:
            verdict = Verdict(False, (judge.implausible(effect) and IMPLAUSIBLE) or "less probable than another")
        is_there = verdict.is_unproven or verdict.reason == UNSTEADY
        attempts.append(Attempt(effect.key, effect.name, score, verdict.held_out_gain, verdict.reason, is_there))
        if verdict.is_added:
            better = model.settled()
    return attempts, better, unnamed


def _scored(
    fitted: Fitted, dictionary: Dictionary, candidates: Sequence[_Tried]
) -> tuple[list[tuple[float, Effect, Fitted]], dict[str, Finding]]:
    """Logs of Bayes factors, the largest first, with the noise that the best fit leaves; and all that was screened,
    with that noise, by key."""
    excess = min([fitted.excess, *(one.model.excess for one in candidates)])
    again = {f.effect.key: f for f in findings(dictionary, replace(fitted.loose, excess=excess))}
    scored, before = [], fitted.chi_squared({effect.key for effect in fitted.added}) if candidates else 0.0
    for one in candidates:
        gain = one.gain
        if _keeps_noise(one.effect):
            refitted = 0.5 * (before * one.model.n_rows / fitted.n_rows - one.left)
            most = np.inf if _is_late(one.effect) else gain * MOST_BY_REFIT
            gain = float(np.clip(refitted, gain / MOST_BY_REFIT, most))
        scored.append((gain / excess + again[one.effect.key].occam, one.effect, one.model))
    return sorted(scored, key=lambda each: -each[0]), again


def _is_late(effect: Effect) -> bool:
    """Of which linear fits tell little: there, wrenches are late by a share of a step."""
    return effect.lateness > 0


def _keeps_noise(effect: Effect) -> bool:
    """Whether wrenches that are corrected for it have the noise of those that are recorded: one that divides wrenches
    divides their noise too, and takes chi-squared away for nothing."""
    if not isinstance(effect, SensorEffect):
        return True
    slope = effect.corrected(np.zeros(6), effect.values).by_memory
    return slope is None or bool(np.allclose(slope @ np.swapaxes(slope, -1, -2), np.eye(6), atol=1e-6))
