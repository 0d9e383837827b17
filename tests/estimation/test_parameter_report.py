"""What people are told of an online estimate's parameters."""

import numpy as np
import pytest

from cartgrasp.effects import StribeckFriction
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation import Prior
from estimation.parameter_report import ParameterReport


@pytest.mark.parametrize("breakaway", [0.0, 3.0])
def test_at_a_bound_nothing_is_taught(breakaway):
    """However well it is known: the data may want it beyond."""
    cart = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(StribeckFriction(breakaway=breakaway, speed=0.05),))
    size = len(cart.parameters)
    told = ParameterReport(cart, Prior()).of(cart.parameters, 1e-6 * np.eye(size), np.full(size, 1e-3))
    assert told["mass"].identifiable
    assert told["stribeck_friction.breakaway"].identifiable == (breakaway > 0.0)
