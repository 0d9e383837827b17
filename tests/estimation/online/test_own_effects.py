"""Online filters of carts with an effect that is worked out in numpy, against the same effect with a kernel."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from cartgrasp.effects import Contribution, ForceEffect, Parameter, RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation import CartFilter, FilterNoise, RegressorEstimator

from ..runs import simulate

NOISE = FilterNoise(0.0004, 0.0004, 0.005, 0.005, 0.0, 0.0, disturbance=0.02, slip=0.00005)
BESIDE = {"alone": (), "beside rolling resistance": (RollingResistance(0.02),)}
beside_others = pytest.mark.parametrize("others", BESIDE.values(), ids=BESIDE.keys())


@dataclass(frozen=True)
class OwnDrag(ForceEffect):
    """`viscous_drag`, as a user writes it."""

    linear: float = 0.0
    angular: float = 0.0

    name: ClassVar[str] = "own_drag"
    parameters: ClassVar[tuple[Parameter, ...]] = ViscousDrag.parameters

    def wrench_b(self, situation, memory, parameters):
        against = np.stack([parameters[..., 0], parameters[..., 0], parameters[..., 1]], axis=-1)
        value = -against * situation.velocity_b
        by_parameters = np.zeros((*value.shape, 2))
        by_parameters[..., :2, 0], by_parameters[..., 2, 1] = (
            -situation.velocity_b[..., :2],
            -situation.velocity_b[..., 2],
        )
        return Contribution(value, by_velocity=-against[..., None] * np.eye(3), by_parameters=by_parameters)


def cart(drag, others):
    return CartModel(Inertia(20.0, (0.3, 0.0), 1.8), effects=(drag, *others))


@beside_others
def test_stiction_has_the_axes_in_front_that_states_have(others):
    """One that works in numpy has none; what else may hold the cart does as it would without it."""
    own, kernels = cart(OwnDrag(3.0, 1.2), others), cart(ViscousDrag(3.0, 1.2), others)
    states = np.tile(own.state(velocity=(0.001, 0.0)), (2, 4, 1))
    for at in (states, states[0], states[0, 0]):
        found = own.stiction(at, own.parameters)
        np.testing.assert_allclose(found, kernels.stiction(at, kernels.parameters), rtol=1e-12)
        assert found.shape[:-1] == (*at.shape[:-1], 3)
    of_many = np.tile(own.parameters, (4, 1))
    assert own.stiction(states[0, 0], of_many).shape[:2] == (4, 3)


@pytest.mark.parametrize("online", [CartFilter, RegressorEstimator])
@beside_others
def test_filters_learn_as_with_a_kernel(online, others):
    log, _ = simulate((24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.02 if others else 0.0), duration=6.0)
    own, kernels = (online(cart(drag(3.0, 1.2), others), ["hand"], noise=NOISE) for drag in (OwnDrag, ViscousDrag))
    for measurement in log.measurements():
        told, wanted = own.update(measurement), kernels.update(measurement)
    np.testing.assert_allclose(told.model_parameters, wanted.model_parameters, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(told.covariance, wanted.covariance, rtol=1e-5, atol=1e-9)
    assert wanted.parameters["mass"].value == pytest.approx(24.0, abs=1.0)
