"""How fast a wrench wanders, told from its samples."""

import numpy as np
import pytest

from estimation.online.augmented.wrench_walk import WrenchWalk

STEP, NOISE, UNKNOWN = 0.01, 1.0, np.array([1e4])


def told(wrench, seed=0):
    """Rate and fade after samples with unit noise."""
    walk = WrenchWalk(UNKNOWN)
    samples = wrench + NOISE * np.random.default_rng(seed).normal(size=len(wrench))
    for i, sample in enumerate(samples):
        walk.note(i * STEP, np.array([sample]), np.array([NOISE**2]))
    rate, fade = walk.at(len(wrench) * STEP)
    return rate[0], fade[0]


@pytest.mark.parametrize("sd", [1.0, 4.0, 12.0])
def test_the_rate_of_a_true_random_walk(sd):
    """N/√s, against the walk drawn; the bank's gains are a factor 2 apart."""
    steps = sd * np.sqrt(STEP) * np.random.default_rng(1).normal(size=4000)
    rates = [told(np.cumsum(steps), seed)[0] ** 0.5 for seed in range(5)]
    assert sd / 2 < np.median(rates) < 2 * sd


def test_a_wrench_at_rest_hardly_walks_and_fades():
    rate, fade = told(np.zeros(2000))
    assert rate < 0.1
    assert fade > 0


def test_a_strong_wrench_keeps_its_power():
    time = STEP * np.arange(4000)
    rate, fade = told(20 * np.sin(2 * time))
    assert rate / (2 * fade) == pytest.approx(200.0, rel=0.2)


def test_a_jump_is_no_walk():
    """A walk that made the same way in those 30 s would gain 30 N²/s."""
    assert told(np.repeat([0.0, 30.0], [2000, 1000]))[0] < 1.0


def test_without_samples_nothing_is_known():
    walk = WrenchWalk(UNKNOWN)
    assert (walk.at(0.0)[0] == UNKNOWN).all()
    for i in range(100):
        walk.note(i * STEP, np.zeros(1), np.ones(1))
    assert walk.at(1.0)[0] < UNKNOWN
    assert (walk.at(3.0)[0] == UNKNOWN).all()
