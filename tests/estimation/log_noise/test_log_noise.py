"""What is read off a log: the noise that its sensors had, and what no model explains of casters."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import CasterRealignment, RollingResistance, ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.wheels import CASTER, FIXED, Wheel
from estimation.log_noise.log_noise import noise_of_log
from estimation.noise import FilterNoise

from ..runs import simulate_two_hands

TRUTH = (30.0, 0.3, 0.05, 2.7, 2.0, 0.4, 0.0)
WHEELS = (Wheel(FIXED, 0.0, 0.3), Wheel(FIXED, 0.0, -0.3), *(Wheel(CASTER, 0.6, y, trail=0.05) for y in (0.3, -0.3)))
PLAIN = CartModel(Inertia(25.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(2.0, 0.5),), wheels=WHEELS)


@pytest.fixture(scope="module")
def log():
    return simulate_two_hands(TRUTH, 5, noise=(0.0005, 0.005, 2.0))


def test_sensors_are_as_noisy_as_they_were_made(log):
    told = noise_of_log(log, PLAIN)
    assert told.position == pytest.approx(0.0005, rel=0.1)
    assert told.linear_velocity == pytest.approx(0.005, rel=0.1)
    assert told.force == pytest.approx(2.0, rel=0.15)


def test_casters_leave_out_a_tenth_of_what_they_push_aside_where_they_stand(log):
    """0.2 N·m over 50 mm, two of them: 8 N; beside a hundredth of the forward force."""
    without, beside = (
        noise_of_log(log, replace(PLAIN, effects=(*PLAIN.effects, effect)))
        for effect in (RollingResistance(0.01), CasterRealignment(0.2))
    )
    assert without == noise_of_log(log, PLAIN)
    assert without.lever == FilterNoise().lever
    assert beside.disturbance == pytest.approx(math.hypot(without.disturbance, 0.8))
    moment = (beside.lever * beside.disturbance) ** 2
    assert moment == pytest.approx((without.lever * without.disturbance) ** 2 + 0.8**2 * (0.6**2 + 0.3**2))
    shorter = noise_of_log(log, replace(PLAIN, effects=(CasterRealignment(0.2, trail=0.025),)))
    assert shorter.disturbance == pytest.approx(math.hypot(without.disturbance, 1.6))
    assert np.isfinite([shorter.lever, beside.lever]).all()
