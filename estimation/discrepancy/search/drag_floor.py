"""The least that a drag which follows something ever was, named as rolling resistance: every wheel resists."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cartgrasp.effects import RollingResistance
from cartgrasp.wheels import GRAVITY

from .laws import Law, seen_values
from .model import Model
from .plausible import TOLD, is_negligible


def with_floor_named(model: Model) -> Model:
    """The model with rolling resistance in place of the least that a drag of one of its laws ever was."""
    if RollingResistance.name in model.names:
        return model
    for law, place in zip(model.laws, model.law_places, strict=True):
        force = law.effects[0]
        if force.acts_on != "drag" or not law.has_constant:
            continue
        seen = seen_values(force, model.motions)
        shares = force.shares(seen) @ law.basis
        drag = shares @ model.score.fit[place]
        least = int(np.argmin(drag))
        std = float(np.sqrt(shares[least] @ model.score.covariance[place, place] @ shares[least]))
        weight = GRAVITY * model.cart.inertia.mass
        if is_negligible(RollingResistance(max(drag[least] - TOLD * std, 0.0) / weight)):
            continue
        laws = tuple(_beyond(one, shares[least]) if one is law else one for one in model.laws)
        cart = model.cart.with_effect(RollingResistance(float(drag[least]) / weight))
        return replace(model, laws=laws).refitted(cart)
    return model


def _beyond(law: Law, share: np.ndarray) -> Law:
    """The law less what is the same everywhere: it is zero where its numbers have these shares (q,)."""
    rest = np.linalg.svd(law.basis - share)
    return replace(law, basis=rest.U[:, : law.size - 1] * rest.S[: law.size - 1])
