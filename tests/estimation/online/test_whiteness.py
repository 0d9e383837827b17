"""Innovations that pull the same way for longer than a sample are no right model's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import lfilter

from estimation.online.whiteness import INNOVATION_SPAN, Whiteness


def told(innovations, variance, rate=10.0):
    """After innovations (n, k) that pull with a variance (k, k) each."""
    found = Whiteness()
    for i, pull in enumerate(innovations):
        found = found.and_then(i / rate, pull, variance)
    return found


@given(st.integers(0, 10_000), st.integers(1, 6))
def test_white_ones_are_called_so(seed, k):
    """Of any covariance, singular ones, too: in a minute, with a chance of less than one in ten thousand."""
    random = np.random.default_rng(seed)
    root = random.standard_normal((k, k)) * 10.0 ** random.uniform(-3, 3, k)
    root[:, 0] *= random.integers(2)
    found = told(random.standard_normal((600, k)) @ root, root.T @ root)
    assert not found.is_coloured


@pytest.mark.parametrize("memory", [0.6, 0.9])
def test_those_that_remember_are_not(memory):
    """As loud as they are told to be, sums of n have (1 + a) / (1 - a) - 2 a (1 - aⁿ) / (n (1 - a)²) times the square
    (Bartlett, 1946)."""
    random = np.random.default_rng(4)
    pulls = lfilter([(1 - memory**2) ** 0.5], [1.0, -memory], random.standard_normal((60_000, 2)), axis=0)
    levels = [told(part, np.eye(2)).level for part in np.split(pulls, 100)]
    n, gap = 10 * INNOVATION_SPAN, 1 - memory
    expected = (1 + memory) / gap - 2 * memory * (1 - memory**n) / (n * gap**2)
    assert np.mean(levels) == pytest.approx(expected, rel=0.15)
    assert told(pulls, np.eye(2)).is_coloured


def test_what_was_summed_before_an_interruption_is_forgotten():
    found = told(np.full((round(10 * INNOVATION_SPAN), 1), 9.0), np.eye(1)).interrupted()
    assert found.level == 1.0
    assert not told(np.zeros((600, 1)), np.eye(1)).is_coloured
