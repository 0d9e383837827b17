"""Which effects a model lacks: one added at a time, the most probable, for as long as one is worth it.

An effect is named with evidence, and a gain on stretches that no fit saw, and amplitudes of a sign and size that it can
have. After each addition the earlier ones are tested for removal.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import logsumexp

from cartgrasp.effects import Effect, SensorEffect
from cartgrasp.model import CartModel

from ..batch.wrench_regression import WrenchRegression
from .evidence import findings
from .fitted import Fitted
from .held_out import HeldOut
from .log_check import moving
from .refinement import Refiner
from .vocabulary import trials

MOST_TRIED = 4
"""Effects that are fitted at every step."""
WORTH_TRYING = 3.0
"""Log of a Bayes factor: below it nobody looks closer."""
HOPELESS = 0.4
"""Of the best one's: what screens below it does not win by refinement."""
ENOUGH = 7.0
"""Log of the Bayes factor of an effect that is named."""
LEAST_GAIN = 0.05
"""Of the gap above the noise floor, on stretches that no fit saw."""
NOT_TOLD_APART = 4.6
"""Difference of logs of Bayes factors: a hundredth."""
MOST_EFFECTS = 4
SETTING_STD = {"s": 0.02, "m": 0.02}


@dataclass(frozen=True)
class Attempt:
    """An effect tried at a step: the log of its Bayes factor, and what it gains on held-out stretches, as a share of
    the gap above the noise floor that the refitted nominal model had. `verdict` says why it won or lost."""

    key: str
    name: str
    log_factor: float
    held_out_gain: float | None
    verdict: str
    effect: Effect

    @property
    def setting_std(self) -> dict[str, float]:
        """Of settings that a search found and no linear fit: as fine as it searched."""
        return {p.name: SETTING_STD[p.unit] for p in self.effect.parameters if p.unit in SETTING_STD}


@dataclass(frozen=True)
class Step:
    """One round: what was tried, and which was added, if any."""

    attempts: tuple[Attempt, ...]
    added: Attempt | None
    confusable: tuple[str, ...] = ()
    probability: float = 1.0


@dataclass(frozen=True)
class Selection:
    nominal: Fitted
    final: Fitted
    steps: tuple[Step, ...]
    held_out: HeldOut


def select(
    whole: Sequence[WrenchRegression], cart: CartModel, arms: Sequence[str], tell: Callable[[str], None]
) -> Selection:
    nominal = Fitted(tuple(regression.within(moving(regression)) for regression in whole), cart)
    held_out = HeldOut(nominal, whole)
    fitted, steps = nominal, list[Step]()
    while len(steps) < MOST_EFFECTS:
        tell(f"step {len(steps) + 1}: screening")
        step, better = _step(fitted, held_out, arms, tell)
        steps.append(step)
        if better is None:
            break
        fitted = better
    return Selection(nominal, fitted, tuple(steps), held_out)


def _step(
    fitted: Fitted, held_out: HeldOut, arms: Sequence[str], tell: Callable[[str], None]
) -> tuple[Step, Fitted | None]:
    effects = trials(fitted.cart, arms)
    dictionary = fitted.dictionary(effects)
    screened = findings(dictionary, fitted.base)
    refiner = Refiner(fitted)
    tried = []
    for finding in screened[:MOST_TRIED]:
        if finding.log_factor < max(WORTH_TRYING, HOPELESS * screened[0].log_factor):
            break
        tell(f"trying {finding.effect.name}")
        effect, gain = refiner.refined(finding.effect, finding.amplitudes, finding.prior_std)
        tried.append((effect, gain.value, fitted.with_added(effect)))
    excess = min([fitted.scatter.excess, *(model.scatter.excess for *_, model in tried)])
    again = {f.effect.key: f for f in findings(dictionary, replace(fitted.base, excess=excess))}
    scored = []
    for effect, most, model in tried:
        if not isinstance(effect, SensorEffect):  # one that divides wrenches would divide their noise too
            most = max(most, 0.5 * (fitted.chi_squared - model.chi_squared))
        scored.append((most / excess + again[effect.key].occam, effect, model))
    scored.sort(key=lambda one: -one[0])
    attempts, added, better = [], None, None
    for score, effect, model in scored:
        share, verdict = None, "less probable than another"
        if added is None:
            share, verdict = _judged(score, model, effect, fitted, held_out)
        attempt = Attempt(effect.key, effect.name, score, share, verdict, effect)
        attempts.append(attempt)
        if verdict == "added":
            added, better = attempt, model
    rest = [f for f in again.values() if f.effect.key not in {a.key for a in attempts}]
    attempts += [
        Attempt(f.effect.key, f.effect.name, f.log_factor, None, "not probable enough", f.effect) for f in rest
    ]
    if added is None:
        return Step(tuple(attempts), None), None
    left = attempts[attempts.index(added) :]
    logs = np.array([a.log_factor for a in left])
    probability = float(np.exp(added.log_factor - logsumexp(np.append(logs, 0.0))))
    near = [a.name for a in left if a.name != added.name and added.log_factor - a.log_factor < NOT_TOLD_APART]
    return Step(tuple(attempts), added, tuple(dict.fromkeys(near)), probability), better


def _judged(score: float, model: Fitted, effect: Effect, fitted: Fitted, held_out: HeldOut) -> tuple[float | None, str]:
    if score < ENOUGH:
        return None, f"log of the Bayes factor {score:.1f} is below {ENOUGH:g}"
    share = held_out.gain(fitted, model, effect)
    if share < LEAST_GAIN:
        return share, f"closes {100 * share:.1f} % of the gap on held-out stretches, less than {100 * LEAST_GAIN:g} %"
    return share, "added"
