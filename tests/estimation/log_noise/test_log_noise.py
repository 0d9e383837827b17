"""What is read off a log: the noise that its sensors had."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.log_noise.log_noise import noise_of_log

from ..runs import simulate_two_hands

TRUTH = (30.0, 0.3, 0.05, 2.7, 2.0, 0.4, 0.0)
PLAIN = CartModel(Inertia(25.0, (0.3, 0.0), 2.0), effects=(ViscousDrag(2.0, 0.5),))


@pytest.fixture(scope="module")
def log():
    return simulate_two_hands(TRUTH, 5, noise=(0.0005, 0.005, 2.0))


@pytest.mark.long
def test_sensors_are_as_noisy_as_they_were_made(log):
    told = noise_of_log(log, PLAIN)
    assert told.position == pytest.approx(0.0005, rel=0.1)
    assert told.linear_velocity == pytest.approx(0.005, rel=0.1)
    assert told.force == pytest.approx(2.0, rel=0.15)


def test_values_in_steps_are_no_better_than_their_rounding():
    """Most of them repeat themselves, and look exact."""
    log = simulate_two_hands(TRUTH, 5, noise=(0.00001, 0.0001, 2.0))
    step = np.array([0.02, 0.02, 0.05])
    told = noise_of_log(replace(log, pose=step * np.round(log.pose / step), velocity=None), PLAIN)
    assert told.position == pytest.approx(0.02 / 12**0.5)
    assert told.heading == pytest.approx(0.05 / 12**0.5)
