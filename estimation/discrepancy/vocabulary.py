"""Which effects a search tries on a cart: every one that is known, at the values where it begins to act."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain, count, product

from cartgrasp.effects import KNOWN_EFFECTS, ConstraintEffect, Effect, SensorEffect
from cartgrasp.model import CartModel
from cartgrasp.wheels import WheelSet


def trials(cart: CartModel, arms: Sequence[str]) -> list[Effect]:
    """Absent effects, one for each point of a class's grid, and for sensors one for each arm."""
    found: list[Effect] = []
    for kind in KNOWN_EFFECTS.values():
        if issubclass(kind, ConstraintEffect):  # they show sideways
            continue
        for label in _labels(kind, cart, arms):
            found.extend(_on_grid(kind, label, cart.wheel_set))
    return found


def _labels(kind: type[Effect], cart: CartModel, arms: Sequence[str]) -> list[str]:
    """Of what this cart does not have yet. Effects that act at a time or a place may come again."""
    taken = {effect.label for effect in cart.effects if isinstance(effect, kind)}
    if issubclass(kind, SensorEffect):
        if "" in taken:
            return []
        if len(arms) > 1 and kind.by_arm:
            return [arm for arm in arms if arm not in taken]
        return [] if taken else [""]
    if taken and not kind.gate.n_parameters:
        return []
    return [next(label for label in chain([""], map(str, count(2))) if label not in taken)]


def _on_grid(kind: type[Effect], label: str, wheels: WheelSet) -> list[Effect]:
    absent = [p.absent for p in kind.parameters]
    grids = [grid or (value,) for grid, value in zip(kind.grids(wheels), absent, strict=True)]
    return [
        kind(**dict(zip((p.name for p in kind.parameters), values, strict=True)), label=label)
        for values in product(*grids)
    ]
