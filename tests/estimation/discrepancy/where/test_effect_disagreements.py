"""What is named tells when and where a model and a log disagree."""

import numpy as np
import pytest

from cartgrasp.effects import ExternalPush, FloorPatch, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.discrepancy.search.model import Model
from estimation.discrepancy.where.residual import residuals
from estimation.discrepancy.where.where import effect_disagreements
from estimation.weak_form.balances import Balances

from ...weak_form.motions import TRUE, cart_of, noisy, weaving


@pytest.mark.parametrize("effect", [ExternalPush(5.0, 1.5, 20.0), FloorPatch(1.0, 2.0, -9.0, 9.0, 0.1)])
def test_it_acts_where_its_force_is(effect):
    """By the force that the cart's model has of it along the motion, to a step of the grid."""
    log = noisy(weaving(TRUE, 24.0), 2)
    cart = cart_of(TRUE)
    nominal = Model.started([Balances.of(log, cart)], cart)
    extended = Model(**{**vars_of(nominal), "cart": nominal.cart.with_effect(effect)})
    (told,) = effect_disagreements(extended, residuals(nominal, nominal))
    (balances,) = extended.logs
    alone = CartModel(Inertia(1.0, (0.0, 0.0), 1.0), effects=(effect,), wheels=cart.wheels)
    state = np.hstack([balances.motion.pose, balances.motion.velocity])
    force = np.abs(alone.effect_wrench(state, time=balances.motion.time)).max(axis=1)
    time = balances.motion.time
    inside = np.any([(time >= a) & (time <= b) for a, b in told.intervals], axis=0)
    assert (inside == (force > 0.5 * force.max())).mean() > 0.97
    assert effect.name in told.condition
    assert ViscousDrag.name not in told.condition


def vars_of(model):
    return {name: getattr(model, name) for name in model.__dataclass_fields__}
