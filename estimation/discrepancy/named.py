"""Effects that were added, as a report tells them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

from cartgrasp.effects import Effect, EndStop
from cartgrasp.effects.effect import Parameter
from cartgrasp.model import CartModel

from ..end_stops import StopEstimate
from .candidates import free_label
from .certainty import Certainty
from .learned import LearnedLaw
from .model import Model
from .plausible import is_negligible
from .rivals import rivals
from .search import Step, added

SURE = 2.0
"""Standard deviations from which on a value is there."""
OPEN_WORLD = 0.95
"""How probable it is that something of the vocabulary is behind what an effect of it explains."""


@dataclass(frozen=True)
class NamedEffect:
    """An effect that was added: how sure that it is this one; parameters' values, standard deviations and units; what
    the log can't tell it apart from; the share of the held-out gap above the noise floor that it closed; of a force
    that no name fits, the law."""

    name: str
    label: str
    probability: float
    parameters: dict[str, tuple[float, float, str]]
    confusable_with: tuple[str, ...]
    gap_share: float
    law: LearnedLaw | None = None

    @property
    def words(self) -> str:
        """In a sentence."""
        alike = f" (or {' or '.join(self.confusable_with)}: these logs can't tell)" if self.confusable_with else ""
        return (self.law.words if self.law else self.name) + alike

    def as_dict(self) -> dict[str, Any]:
        told = {one.name: getattr(self, one.name) for one in fields(self) if one.name != "law"}
        told["parameters"] = {k: {"value": v, "std": s, "unit": u} for k, (v, s, u) in self.parameters.items()}
        told["confusable_with"] = list(self.confusable_with)
        return told if self.law is None else told | {"law": self.law.as_dict()}


def named(
    steps: Sequence[Step], final: Model, certainty: Certainty, shares: Sequence[float]
) -> tuple[NamedEffect, ...]:
    """In order of addition; laws last."""
    by = dict[str, tuple[float, tuple[str, ...], float]]()
    for step, share in zip(steps, shares, strict=True):
        if step.added is not None:
            by.setdefault(step.added.key, (*_told(step), share))
    values, order, found = {effect.key: effect for effect in certainty.cart.effects}, list(by), []
    for effect in sorted(added(final), key=lambda e: order.index(e.key) if e.key in by else len(by)):
        probability, confusable, share = by.get(effect.key, (OPEN_WORLD, (), 0.0))
        parameters = _parameters(values[effect.key], certainty)
        found.append(NamedEffect(effect.name, effect.label, probability, parameters, confusable, share))
    for key, law in certainty.laws:
        probability, confusable, share = by.get(key, (OPEN_WORLD, (), 0.0))
        own = law.effect
        told = zip(own.parameters, own.values.tolist(), law.std.tolist(), strict=True)
        parameters = {p.name: (value, std, p.unit) for p, value, std in told}
        found.append(NamedEffect(own.name, own.label, probability, parameters, confusable, share, law))
    return tuple(found)


def faded(final: Model, certainty: Certainty) -> list[str]:
    """Keys of added effects of which next to nothing is left beside the mass that is told."""
    values = {effect.key: effect for effect in certainty.cart.effects}
    return [effect.key for effect in added(final) if is_negligible(values[effect.key])]


def _told(step: Step) -> tuple[float, tuple[str, ...]]:
    """Of what was added: its probability, and the names of what explains about as much."""
    known = rivals(step)
    names = dict.fromkeys(one.candidate.name for _, one in known if isinstance(one.candidate, Effect))
    return OPEN_WORLD / (1.0 + sum(odds for odds, _ in known)), tuple(names)


def _parameters(effect: Effect, certainty: Certainty) -> dict[str, tuple[float, float, str]]:
    """But for those of which the logs say nothing, where they say something of another."""
    told, untaught = {}, set()
    for parameter, key, value in zip(effect.parameters, effect.keys, effect.values.tolist(), strict=True):
        known, settings = certainty.parameters[key], certainty.settings
        std = settings.get(key, known.std if parameter.estimated else 0.05 * abs(value))
        told[parameter.name] = (float(value), float(std), parameter.unit)
        if parameter.estimated and _says_nothing(parameter, value, std):
            untaught.add(parameter.name)
    estimated = {parameter.name for parameter in effect.parameters if parameter.estimated}
    return told if untaught == estimated else {name: one for name, one in told.items() if name not in untaught}


def _says_nothing(parameter: Parameter, value: float, std: float) -> bool:
    """Whether it may as well be absent as of its usual size."""
    return std > parameter.typical and abs(value - parameter.absent) < SURE * std


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
        found.append(NamedEffect(effect.name, effect.label, OPEN_WORLD, parameters, (), 0.0))
    return tuple(found)
