"""What people are told of an online estimate's parameters."""

import numpy as np
import pytest

from cartgrasp.effects import StribeckFriction
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation import Prior
from estimation.parameter_report import ParameterReport
from estimation.physical_set import PhysicalSet


@pytest.mark.parametrize("breakaway", [0.0, 3.0])
def test_at_a_bound_nothing_is_taught(breakaway):
    """However well it is known: the data may want it beyond."""
    cart = CartModel(Inertia(24.0, (0.3, 0.0), 2.0), effects=(StribeckFriction(breakaway=breakaway, speed=0.05),))
    size = len(cart.parameters)
    told = ParameterReport(cart, Prior()).of(cart.parameters, 1e-6 * np.eye(size), np.full(size, 1e-3))
    assert told["mass"].identifiable
    assert told["stribeck_friction.breakaway"].identifiable == (breakaway > 0.0)


@pytest.mark.parametrize("name", ["mass", "inertia"])
def test_as_light_as_a_cart_may_be_nothing_is_taught(name):
    """The most likely body that a cart can have lies at the edge of what it can: the data want it beyond."""
    cart = CartModel(Inertia(24.0, (0.3, 0.0), 2.0))
    limits = PhysicalSet.of(cart, "test")
    beyond = Inertia(1.0, (0.3, 0.0), 2.0).phi if name == "mass" else Inertia(24.0, (0.3, 0.0), 0.02).phi
    edge = limits.nearest(beyond, np.arange(4), np.diag([1e6, 1e6, 1e6, 1e6]))
    for phi, is_taught in ((edge, False), (cart.inertia.phi, True)):
        told = ParameterReport(cart, Prior()).of(phi, 1e-9 * np.eye(4), np.full(4, 1e-3))
        assert told[name].identifiable is is_taught


def test_a_body_at_its_bound_is_not_taught():
    """A twentieth of the first guess's yaw inertia is the least that is believed."""
    cart = CartModel(Inertia(24.0, (0.3, 0.0), 2.0))
    for about_com, is_taught in ((0.1, False), (0.11, True)):
        phi = Inertia(24.0, (0.3, 0.0), about_com).phi
        told = ParameterReport(cart, Prior()).of(phi, 1e-9 * np.eye(4), np.full(4, 1e-3))
        assert told["inertia"].identifiable == is_taught
        assert told["mass"].identifiable
