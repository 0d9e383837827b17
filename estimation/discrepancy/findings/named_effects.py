"""Effects that were added, as a report tells them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from scipy.special import expit

from cartgrasp.effects import Effect, EndStop
from cartgrasp.model import CartModel

from ...impacts.end_stops import StopEstimate
from ..search.candidates import free_label
from ..search.gains import MIN_GAIN_NATS, added
from ..search.model import Model
from ..search.scored_candidates import ScoredCandidate, SearchStep
from .alternatives import alternatives
from .certainty import Certainty
from .learned_laws import LearnedLaw

PRESENT_SIGMAS = 2.0
"""Standard deviations from which on a value is there."""
NAME_BASE_LOG_ODDS, NAME_GAIN_SLOPE, NAME_LARGEST_GAIN_SLOPE = 3.2, 0.8, 0.7
"""Log odds that a name is true, but for its rivals: where it gains the nats that a name is worth and closes some of
the gap on stretches that no fit saw (else nought); more for each time e as many, and less for each time e that the
largest gain of a step is larger: what is small beside that may be what the form of the first leaves. Fitted to names
whose truth is known (`python -m benchmarks.name_probabilities`)."""
ALTERNATIVE_ODDS_WEIGHT = 0.2
"""Weight of the odds of what explains about as much: that it was not chosen, for it is less simple or less usual,
counts."""
UNTRIED_NAME_PROBABILITY = 0.95
"""How probable a name is that no step added."""


@dataclass(frozen=True)
class NamedEffect:
    """An effect that was added: how sure that its name is right; parameters' values, standard deviations and units;
    what the log can't tell it apart from; the share of the held-out gap above the noise floor that it closed; its gain
    (nats) when it was added (0: no step did); of a force that no name fits, the law."""

    name: str
    label: str
    probability: float
    parameters: dict[str, tuple[float, float, str]]
    confusable_with: tuple[str, ...] = ()
    gap_share: float = 0.0
    gain: float = 0.0
    law: LearnedLaw | None = None

    @property
    def called(self) -> str:
        """The name, with its label."""
        return f"{self.name} {self.label}".rstrip()

    @property
    def alike(self) -> list[str]:
        """What the log can't tell it apart from, in words: its own name is another arm's."""
        return [f"that of another arm than {self.label}" if n == self.name else n for n in self.confusable_with]

    def as_dict(self) -> dict[str, Any]:
        told = {one.name: getattr(self, one.name) for one in fields(self) if one.name != "law"}
        told["parameters"] = {k: {"value": v, "std": s, "unit": u} for k, (v, s, u) in self.parameters.items()}
        told["confusable_with"] = list(self.confusable_with)
        return told if self.law is None else told | {"law": self.law.as_dict()}


_Addition = tuple[SearchStep, ScoredCandidate, float]
"""A step, what it added, and the share of the gap that this closed."""


def named_effects(
    steps: Sequence[SearchStep], final: Model, certainty: Certainty, shares: Sequence[float]
) -> tuple[NamedEffect, ...]:
    """Added effects in order of addition; laws last."""
    by, first = dict[str, _Addition](), _largest(steps)
    for step, share in zip(steps, shares, strict=True):
        if step.added is not None:
            by.setdefault(step.added.key, (step, step.added, share))
    values, order, found = {effect.key: effect for effect in certainty.cart.effects}, list(by), []
    for effect in sorted(added(final), key=lambda e: order.index(e.key) if e.key in by else len(by)):
        parameters = _parameters(values[effect.key], certainty)
        found.append(_named_effect(effect, parameters, by.get(effect.key), first))
    for key, law in certainty.laws:
        sizes = zip(law.effect.parameters, law.effect.values.tolist(), law.std.tolist(), strict=True)
        parameters = {p.name: (value, std, p.unit) for p, value, std in sizes}
        found.append(replace(_named_effect(law.effect, parameters, by.get(key), first), law=law))
    return tuple(found)


def _named_effect(
    effect: Effect, parameters: dict[str, tuple[float, float, str]], addition: _Addition | None, first: float
) -> NamedEffect:
    """What is told of an effect that a step added, or that none did, where the largest gain of a step is the `first`.
    Another arm's effect has the same name."""
    if addition is None:
        return NamedEffect(effect.name, effect.label, UNTRIED_NAME_PROBABILITY, parameters)
    step, own, share = addition
    known = alternatives(step)
    names = dict.fromkeys(one.candidate.name for _, one in known if isinstance(one.candidate, Effect))
    others = sum(odds for odds, one in known if one.candidate.name != own.candidate.name)
    probability = name_probability(own.gain, first, share > 0.0) / (1.0 + ALTERNATIVE_ODDS_WEIGHT * others)
    return NamedEffect(effect.name, effect.label, probability, parameters, tuple(names), share, own.gain)


def grouped(effects: Sequence[NamedEffect]) -> list[list[NamedEffect]]:
    """Groups of effects: each alone, but both parts of one force of the world together."""
    found = list[list[NamedEffect]]()
    for one in effects:
        before = found[-1][-1].law if found else None
        if before and one.law and one.law.is_beside(before):
            found[-1].append(one)
        else:
            found.append([one])
    return found


def words_of(effects: Sequence[NamedEffect], alike: bool = True) -> str:
    """Words for what belongs together, as part of a sentence: the law, or the name, with its size. If `alike`, also
    what it may be as well."""
    one, others = effects[0], effects[0].alike if alike else []
    told = f", or {' or '.join(others)}: these logs can't tell" if others else ""
    if one.law:
        return one.law.words + "".join(more.law.words_beside for more in effects[1:] if more.law) + told
    sizes = (with_unit(f"{name} {value:.3g}", unit) for name, (value, _, unit) in one.parameters.items())
    return f"{one.called} ({', '.join(sizes)}{told})"


def with_unit(number: str, unit: str) -> str:
    """A number with its unit, where it has one."""
    return number if unit == "-" else f"{number} {unit}"


def doubtful_names(steps: Sequence[SearchStep], final: Model, shares: Sequence[float]) -> list[str]:
    """Keys of added effects that are more likely wrong than right, whatever their rivals: what gains little beside
    another, and closes nothing of the gap."""
    first, has = _largest(steps), {effect.key for effect in added(final)}
    known = ((step.added, share) for step, share in zip(steps, shares, strict=True) if step.added)
    return [one.key for one, share in known if one.key in has and name_probability(one.gain, first, share > 0.0) < 0.5]


def _largest(steps: Sequence[SearchStep]) -> float:
    """Largest gain of what was added, nats."""
    return max((step.added.gain for step in steps if step.added), default=0.0)


def name_probability(gain: float, first: float, closes: bool) -> float:
    """How probable a name is that gains so much (nats), where the largest gain is the `first`, and which closes some of
    the gap or none, were there no rivals."""
    more, beside = np.log(max(gain, 1.0) / MIN_GAIN_NATS), np.log(max(gain, 1.0) / max(first, gain, 1.0))
    return float(
        expit((NAME_BASE_LOG_ODDS if closes else 0.0) + NAME_GAIN_SLOPE * more + NAME_LARGEST_GAIN_SLOPE * beside)
    )


def _parameters(effect: Effect, certainty: Certainty) -> dict[str, tuple[float, float, str]]:
    """Values, standard deviations and units of an effect's parameters, but for those that may as well be absent as of
    their usual size, where the logs say something of another."""
    told, untaught = {}, set()
    for parameter, key, value in zip(effect.parameters, effect.keys, effect.values.tolist(), strict=True):
        known, settings = certainty.parameters[key], certainty.settings
        std = settings.get(key, known.std if parameter.estimated else 0.05 * abs(value))
        told[parameter.name] = (float(value), float(std), parameter.unit)
        if parameter.estimated and std > parameter.typical and abs(value - parameter.absent) < PRESENT_SIGMAS * std:
            untaught.add(parameter.name)
    estimated = {parameter.name for parameter in effect.parameters if parameter.estimated}
    return told if untaught == estimated else {name: one for name, one in told.items() if name not in untaught}


def named_stops(stops: Sequence[StopEstimate], cart: CartModel) -> tuple[NamedEffect, ...]:
    """What a cart ran against several times, labelled beside the cart's."""
    found = []
    for stop in stops:
        effect = stop.effect(label=free_label(EndStop, cart))
        cart = cart.with_effect(effect)
        parameters = {
            "position": (stop.position, stop.position_std, "m"),
            "side": (stop.side, 0.0, "-"),
            "restitution": (stop.restitution, stop.restitution_std, "-"),
        }
        found.append(NamedEffect(effect.name, effect.label, UNTRIED_NAME_PROBABILITY, parameters))
    return tuple(found)
