"""The noise that the batch fit sees in a smooth motion and in wrenches, against a known plant with known noise."""

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from estimation.batch.noise_colour import colour_of
from estimation.batch.wrench_regression import WrenchRegression

from .runs import STEP, simulate

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
CART = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))


def test_the_sensors_noise_in_the_motion_is_as_large_as_its_errors():
    log, truth = simulate(TRUTH, 5, 24.0, noise=(0.0004, 0.005, 1.0))
    motion = WrenchRegression(log, CART, None).motion
    random = np.random.default_rng(1)
    drawn = np.sqrt(np.mean([motion.drawn_rows(random) ** 2 for _ in range(4)], axis=(0, 1)))
    rate = np.gradient(truth[:, 3:], STEP, axis=0)
    errors = np.hstack([motion.pose, motion.velocity, motion.acceleration]) - np.hstack([truth, rate])
    steady = np.abs(errors[:, 5]) < 4 * drawn[5]  # pushes step; what follows them late is no noise
    assert steady.mean() > 0.9
    assert np.sqrt((errors[steady] ** 2).mean(axis=0)) == pytest.approx(drawn, rel=0.35)


def test_noise_is_read_off_beside_errors_that_are_known():
    n = 6000
    time, random = np.arange(n) * STEP, np.random.default_rng(2)
    white = 1.5 * random.standard_normal((n, 2))
    smooth = np.ones(15) / 15**0.5
    errors = [np.apply_along_axis(np.convolve, 0, random.standard_normal((n, 2)), smooth, "same") for _ in range(4)]
    alone = colour_of(time, white + errors[0])
    beside = colour_of(time, white + errors[0], 1, np.hstack(errors[1:]))
    assert alone.slow > 0.5
    assert beside.slow == 0.0
    assert beside.white == pytest.approx(2.25, rel=0.1)
