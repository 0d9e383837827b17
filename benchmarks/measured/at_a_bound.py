"""Which parameters are said to be taught and stand where a fit was stopped."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from cartgrasp.effects import KNOWN_EFFECTS
from cartgrasp.effects.effect import Parameter
from cartgrasp.model import CartModel

from .running import Outcome

NEAR = 1e-3
"""Of the bound, or of a parameter's typical size where the bound is 0."""
MASS_SHARES = 0.1, 6.0
"""Of the first guess, at which fits have been stopped."""


def at_a_bound(outcome: Outcome, cart: CartModel) -> list[str]:
    """`COMMAND: NAME`. A report that does not say what was taught tells its mass and the values of what it names as if
    they were."""
    told = []
    for command in ("estimate", "identify"):
        for name, one in outcome.said(command).get("parameters", {}).items():
            if one["identifiable"] and _stopped(name, one["value"], outcome.guess, cart):
                told.append(f"{command}: {name}")
    report = outcome.said("discrepancy")
    mass = report.get("parameter_mismatch", {}).get("mass")
    if mass and mass.get("identifiable", True) and _at_a_share(mass["refitted"], outcome.guess):
        told.append("discrepancy: mass")
    return told + [f"discrepancy: {name}" for name in _named_at_a_bound(report)]


def _stopped(name: str, value: float | None, guess: float, cart: CartModel) -> bool:
    if value is None:
        return False
    if name == "mass":
        return _at_a_share(value, guess)
    bounds = {key: p for e in cart.effects for key, p in zip(e.keys, e.parameters, strict=True)}
    return name in bounds and _at_an_end(value, bounds[name])


def _at_a_share(mass: float | None, guess: float) -> bool:
    return mass is not None and any(abs(mass - share * guess) < NEAR * share * guess for share in MASS_SHARES)


def _at_an_end(value: float, parameter: Parameter) -> bool:
    ends = (end for end in (parameter.lower, parameter.upper) if math.isfinite(end))
    return any(abs(value - end) <= NEAR * (abs(end) or parameter.typical) for end in ends)


def _named_at_a_bound(report: Mapping[str, Any]) -> Iterator[str]:
    """Of effects that are told; what is at the value at which it is absent was not moved."""
    for effect in report.get("effects", ()):
        known = KNOWN_EFFECTS.get(effect["name"])
        for parameter in known().parameters if known else ():
            told = effect["parameters"].get(parameter.name, {})
            value = told.get("value")
            moved = parameter.estimated and value is not None and value != parameter.absent
            if moved and _at_an_end(value, parameter):
                yield f"{effect['name']}.{parameter.name}"
