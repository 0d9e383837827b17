"""The cart and the hands that benchmarks of planning share."""

from __future__ import annotations

from collections.abc import Sequence

from cartgrasp import Arm, CartModel, Inertia
from cartgrasp.friction import Friction

CART = CartModel(Inertia(24.0, (0.3, 0.0), 2.0))


def hand(name: str, contacts: Sequence[Sequence[float]] = (), segment: Sequence[Sequence[float]] | None = None) -> Arm:
    return Arm(
        name,
        contacts,
        segment=segment,
        force_limit=(60.0, 60.0, 40.0),
        moment_limit=(8.0, 8.0, 6.0),
        friction=Friction(0.6, 4),
    )
