"""What may be missing: effects of the vocabulary at settings of a grid, as columns of a log's rows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, count, product

import numpy as np

from cartgrasp.effects import KNOWN_EFFECTS, ConstraintEffect, Effect, LearnedForce, SensorEffect
from cartgrasp.effects.effect import Gate
from cartgrasp.effects.force_scale import ForceScale
from cartgrasp.effects.time_delay import TimeDelay
from cartgrasp.model import CartModel

from ...weak_form.band import INERTIAL_EFFECTS

DRAGS_TOLD_BY_TURNING = ("wheel_drag_imbalance",)
"""Drags that only turning tells from other drags: a cart on a rail, which does not turn, is given none of them. Pure
yaw moments do nothing to it, and need no entry."""
UNBOUNDED_LENGTH = 1e12
"""Time (s) and distance (m) that are as long, and as far, as no log goes."""


@dataclass(frozen=True)
class Family:
    """Variants of one effect, of which a search takes the best."""

    key: str
    variants: tuple[Effect, ...]


def families(cart: CartModel, arms: Sequence[str], others: Sequence[Effect] = ()) -> list[Family]:
    """Every effect of the vocabulary that the cart may have beside those it has, gates open; and others that are no
    laws, as they are."""
    has = {effect.key for effect in cart.effects}
    own = (one for one in others if not isinstance(one, LearnedForce) and one.key not in has)
    found = [Family(one.key, (one,)) for one in own]
    for kind in KNOWN_EFFECTS.values():
        if not kind.searched or (not arms and (kind.name in INERTIAL_EFFECTS or is_of_wrenches(kind))):
            continue
        if cart.constraints.no_rotation and kind.name in DRAGS_TOLD_BY_TURNING:
            continue
        for label in _labels(kind, cart, arms):
            variants = tuple(_variants(kind, label, cart))
            found.append(Family(variants[0].key, variants))
    return found


def is_of_wrenches(kind: type[Effect]) -> bool:
    """Whether it stands between true and recorded wrenches."""
    return issubclass(kind, SensorEffect) and not kind.moves_pose


def is_of_motion(kind: type[Effect]) -> bool:
    """Whether it shows in the speed across the wheels, and in wrenches next to nothing."""
    return issubclass(kind, ConstraintEffect) or (issubclass(kind, SensorEffect) and kind.moves_pose)


def amplitudes_of(effect: Effect) -> np.ndarray:
    """Indices of the parameters in which it is linear near absence."""
    gated = effect.gate.n_parameters
    return np.array([i for i, p in enumerate(effect.parameters) if i >= gated and not p.grid], dtype=int)


def _labels(kind: type[Effect], cart: CartModel, arms: Sequence[str]) -> Iterator[str]:
    taken = {effect.label for effect in cart.effects if isinstance(effect, kind)}
    if is_of_motion(kind):
        if not taken and cart.constraints.n_rows == 1:
            yield ""
    elif issubclass(kind, SensorEffect):
        by_arm = kind.by_arm and len(arms) > 1
        if "" not in taken:
            left = [arm for arm in arms if arm not in taken] if by_arm else ([] if taken else [""])
            if kind is not ForceScale or len(left) > 1:  # were all wrong, the cart would be another
                yield from left
    elif not taken or kind.gate.n_parameters:
        yield free_label(kind, cart)


def free_label(kind: type[Effect], cart: CartModel) -> str:
    """A label that no effect of this kind has: none, or else 2, 3 and so on."""
    taken = {effect.label for effect in cart.effects if isinstance(effect, kind)}
    return next(label for label in chain([""], map(str, count(2))) if label not in taken)


def _variants(kind: type[Effect], label: str, cart: CartModel) -> Iterator[Effect]:
    if issubclass(kind, ConstraintEffect):
        yield kind.usual(label)
    elif kind is TimeDelay:
        for delay in (0.01, 0.02, 0.03, 0.045, 0.065, 0.09, 0.13, 0.2):
            yield TimeDelay(delay, label=label)
    else:
        far, effect = UNBOUNDED_LENGTH, kind(label=label)
        gates = {Gate.FROM: [-far], Gate.WHILE: [-far, 2 * far], Gate.INSIDE: [-far, far, -far, far]}
        gate = gates.get(kind.gate, [])
        absent = gate + effect.values[len(gate) :].tolist()
        grids = [grid or (value,) for grid, value in zip(effect.grids(cart.wheel_set), absent, strict=True)]
        for values in product(*grids):
            yield effect.with_values(values)
