"""The steps in which values come, whatever was done to them after the sensor."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from estimation.log_noise.resolution import resolution
from tests.core.drawn import numbers


def way(seed, rest=300, go=700, noise=1e-4):
    """Of a cart that rests and sets off, m, by row."""
    rows = np.arange(rest + go)
    return 2e-6 * np.maximum(rows - rest, 0.0) ** 2 + noise * np.random.default_rng(seed).standard_normal(len(rows))


@given(seed=st.integers(0, 99), step=numbers(0.0005, 0.01))
def test_of_rounded_values_it_is_the_step(seed, step):
    assert resolution(step * np.round(way(seed) / step)) == pytest.approx(step)


@given(seed=st.integers(0, 99), step=numbers(0.002, 0.01), into=numbers(0.0, 1.0), mean=st.booleans())
def test_of_rounded_values_that_were_resampled_or_averaged_it_is_not_far_off(seed, step, into, mean):
    """The smallest difference would be any part of a step."""
    rounded = step * np.round(way(seed) / step)
    at = np.arange(0, len(rounded) - 2, 2) + into
    found = rounded.reshape(-1, 2).mean(axis=1) if mean else np.interp(at, np.arange(len(rounded)), rounded)
    assert 0.4 * step < resolution(found) < 1.01 * step


@given(seed=st.integers(0, 99), noise=numbers(1e-4, 0.01))
def test_what_never_repeats_is_as_fine_as_it_comes(seed, noise):
    values = way(seed, noise=noise)
    assert resolution(values) == np.abs(np.diff(values)).min()


def test_what_never_changes_has_none():
    assert resolution(np.full(20, 3.0)) == resolution(np.full(5, np.nan)) == 0.0
