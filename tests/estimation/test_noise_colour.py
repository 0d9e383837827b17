"""Coloured wrench noise: read off differences, and as states beside the motion's."""

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.constraints import RollingConstraints
from cartgrasp.inertia import Inertia
from cartgrasp.logs import ArmLog
from cartgrasp.model import CartModel
from estimation.batch.block_tridiagonal import BlockTridiagonal
from estimation.batch.noise_colour import NoiseColour, colour_of, with_noise_states
from estimation.batch.wrench_regression import WrenchRegression

from .runs import simulate_two_hands

TIME = np.arange(0, 60, 0.01)


def autoregression(time_constant, rows=TIME, columns=2, seed=0):
    random = np.random.default_rng(seed)
    fade = np.exp(-0.01 / time_constant)
    noise = random.standard_normal((len(rows), columns))
    for k in range(1, len(rows)):
        noise[k] = fade * noise[k - 1] + (1 - fade**2) ** 0.5 * noise[k]
    return noise


@pytest.mark.parametrize("time_constant", [0.03, 0.06, 0.12])
def test_variance_and_time_are_read_off_beside_white_noise_and_a_slow_misfit(time_constant):
    random = np.random.default_rng(1)
    slow = np.sin(2 * np.pi * 0.1 * TIME)[:, None]
    found = colour_of(TIME, 2 * autoregression(time_constant) + 0.7 * random.standard_normal((len(TIME), 2)) + slow)
    assert found.time == pytest.approx(time_constant, rel=0.35)
    assert found.slow == pytest.approx(4.0, rel=0.35)
    assert found.white == pytest.approx(0.49, rel=0.5)


def test_means_of_two_have_the_colour_of_one():
    """Variances are in units of the mean's, which is believed to be half as large."""
    noise = autoregression(0.05, np.arange(0, 300, 0.01))
    pairs = 2**0.5 * (noise[::2] + noise[1::2]) / 2
    found = colour_of(np.arange(0, 300, 0.02), pairs, size=2)
    assert found.time == pytest.approx(0.05, rel=0.15)
    assert found.slow == pytest.approx(2.0, rel=0.15)


def test_white_noise_has_no_colour():
    assert colour_of(TIME, np.random.default_rng(2).standard_normal((len(TIME), 2))) is None


def test_too_few_rows_have_none():
    assert colour_of(TIME[:50], autoregression(0.06)[:50]) is None


def test_long_means_are_as_uncertain_as_a_colour_says():
    colour = NoiseColour(0.5, 2.0, 0.05)
    random = np.random.default_rng(3)
    rows = np.arange(0, 2000, 0.01)
    noise = 2**0.5 * autoregression(0.05, rows, 1) + 0.5**0.5 * random.standard_normal((len(rows), 1))
    means = noise[: len(rows) // 500 * 500].reshape(-1, 500).mean(axis=1)
    assert means.var() * 500 == pytest.approx(2.5 * colour.long_mean(0.01), rel=0.25)


def test_the_states_have_an_autoregression_s_covariance():
    """Of a chain without any motion to know, and one that begins anew after a gap."""
    n, colour = 7, NoiseColour(0.1, 3.0, 0.04)
    covariance = np.array([[2.0, 0.3], [0.3, 0.5]])
    steps, linked = np.array([0.01, 0.02, 0.01, 0.5, 0.01, 0.01]), np.array([True, True, True, False, True, True])
    motion = BlockTridiagonal(np.tile(np.eye(3), (n, 1, 1)), np.zeros((n - 1, 3, 3)))
    chain = with_noise_states(motion, linked, steps, covariance, colour)
    whole = np.zeros((5 * n, 5 * n))
    for i in range(n):
        whole[5 * i : 5 * i + 5, 5 * i : 5 * i + 5] = chain.diagonal[i]
    for i in range(n - 1):
        whole[5 * i + 5 : 5 * i + 10, 5 * i : 5 * i + 5] = chain.below[i]
        whole[5 * i : 5 * i + 5, 5 * i + 5 : 5 * i + 10] = chain.below[i].T
    found = np.linalg.inv(whole).reshape(n, 5, n, 5)[:, 3:, :, 3:]
    at, group = np.append(0, np.cumsum(steps)), np.append(0, np.cumsum(~linked))
    fade = np.exp(-np.abs(at[:, None] - at) / colour.time) * (group[:, None] == group)
    assert found == pytest.approx(colour.slow * fade[:, None, :, None] * covariance[None, :, None, :], abs=1e-9)


def test_coloured_noise_of_an_arm_that_regrasps():
    """On casters alone: the usual noise at three places of its hand is that of no single one."""
    log = simulate_two_hands((24.0, 0.28, 0.06, 2.2, 3.0, 1.2, 0.0), 0, 6.0)
    third, places = len(log) // 3, np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [1.0, 1.0, 1.0]])
    contact = np.repeat(places, [third, third, len(log) - 2 * third], axis=0)
    regrasped = replace(log, arms={"hand": ArmLog(contact, log.arms["left"].wrench)})
    cart = CartModel(Inertia(24.0, (0.28, 0.06), 2.2), RollingConstraints(None))
    regression = WrenchRegression(regrasped, cart, None).coloured(NoiseColour(0.3, 5.0, 0.05))
    evidence = regression.evidence(cart.parameters, 0.25)
    assert np.linalg.eigvalsh(evidence.blocks.sum(axis=0)).min() > 0
