"""What noise alone does to rollouts, against a known plant with known noise, integrated by the tests' own equations."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.effects import ViscousDrag
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog
from cartgrasp.model import CartModel
from estimation.batch.noise_colour import colour_of
from estimation.batch.wrench_regression import WrenchRegression
from estimation.discrepancy.fitted import Fitted
from estimation.discrepancy.held_out import HeldOut
from estimation.discrepancy.rollouts import starts

from .runs import STEP, reduced_rate, simulate, simulate_two_hands

TRUTH = (24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0)
CART = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), effects=(ViscousDrag(linear=3.0, angular=1.2),))
ROWS = 100
"""Of a rollout."""


def slow_noise(n, columns, time_constant, seed):
    random = np.random.default_rng(seed)
    fade = np.exp(-STEP / time_constant)
    noise = random.standard_normal((n, columns))
    for k in range(1, n):
        noise[k] = fade * noise[k - 1] + (1 - fade**2) ** 0.5 * noise[k]
    return noise


def recorded(seed, force, slow):
    """A log with white wrench noise of `force` (N), and slow noise of `slow` (N)."""
    log = simulate_two_hands(TRUTH, seed, 24.0, noise=(0.0004, 0.005, force))
    scale, arms = slow * np.array([1.0, 1.0, 1.0, 0.05, 0.05, 0.05]), {}
    for k, (name, arm) in enumerate(log.arms.items()):
        arms[name] = ArmLog(arm.contact, arm.wrench + scale * slow_noise(len(log), 6, 0.04, 100 + 2 * seed + k))
    return replace(log, arms=arms)


def reduced(log):
    """Forward force and moment about {b} (n, 2), of both hands."""
    return sum(
        np.column_stack([w[:, 0], w[:, 5] + px * w[:, 1] - py * w[:, 0]])
        for w, (px, py, _) in ((arm.wrench, arm.contact[0]) for arm in log.arms.values())
    )


def misses(regression, log):
    """Squared distances (r,) by which the true cart, pushed by the recorded wrenches, misses the motion after 1 s."""
    wrench, motion, found = reduced(log), regression.motion, []
    for first in starts(regression, np.ones(len(motion.time), dtype=bool), ROWS * STEP, 0.5):
        state = np.append(motion.pose[first], motion.velocity[first])
        for k in range(first, first + ROWS):
            fx, tau = wrench[k]
            k1 = reduced_rate(state, fx, tau, TRUTH)
            k2 = reduced_rate(state + STEP / 2 * k1, fx, tau, TRUTH)
            k3 = reduced_rate(state + STEP / 2 * k2, fx, tau, TRUTH)
            k4 = reduced_rate(state + STEP * k3, fx, tau, TRUTH)
            state = state + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        found.append(((state[:2] - motion.pose[first + ROWS, :2]) ** 2).sum())
    return found


@pytest.mark.parametrize(("force", "slow"), [(1.0, 0.0), (3.0, 0.0), (0.5, 3.0)])
def test_the_floor_is_what_a_true_model_does(force, slow):
    true, floors = [], []
    for seed in range(6):
        log = recorded(seed, force, slow)
        regression = WrenchRegression(log, CART, None)
        true += misses(regression, log)
        fitted = Fitted((regression,), CART).coloured()
        floors.append(HeldOut(fitted, fitted.regressions, everywhere=True).floor(fitted))
    assert np.sqrt(np.mean(np.square(floors))) == pytest.approx(np.sqrt(np.mean(true)), rel=0.25)


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
