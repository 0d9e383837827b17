"""Sums against bumps are the integrals that they stand for, whatever the times."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from estimation.sensor_check.weak_form import Bumps

SEEDS = st.integers(0, 2**32 - 1)


def phi(t, centre, width):
    s = (t - centre) / (width / 2)
    return (1 - s**2) ** 4 if abs(s) < 1 else 0.0


def uneven(seed, n=900, step=0.01):
    random = np.random.default_rng(seed)
    return np.cumsum(step * random.uniform(0.5, 1.5, n))


@given(SEEDS, st.floats(0.4, 1.5), st.floats(0.1, 3.0), st.floats(-0.1, 0.1))
def test_integrals_are_those_of_a_quadrature(seed, width, rate, late):
    time = uneven(seed)
    bumps = Bumps.over(time, width)
    sums = bumps.on(time, late)
    for k in (len(bumps.centres) // 3, len(bumps.centres) // 2):
        centre = bumps.centres[k]
        ends = centre - width / 2, centre + width / 2
        wanted, _ = quad(lambda t, c=centre: phi(t, c, width) * np.cos(rate * (t + late)), *ends)
        assert sums.covered[k]
        assert sums.integral(np.cos(rate * time))[k] == pytest.approx(wanted, abs=2e-4 * width)


@given(SEEDS, st.floats(0.5, 1.5), st.floats(0.1, 3.0))
def test_nothing_needs_to_be_differentiated(seed, width, rate):
    """∫ phi g dx = ∫ phi g x' dt and -∫ phi' x dt = ∫ phi x' dt: samples of x alone tell what x' does;
    to the square of the longest step over the width."""
    time = uneven(seed)
    sums = Bumps.over(time, width).on(time)
    x, speed, factor = np.sin(rate * time), rate * np.cos(rate * time), 1 + 0.3 * np.cos(2 * time)
    coarse = (0.015 / width) ** 2
    assert sums.along(factor, x) == pytest.approx(sums.integral(factor * speed), abs=coarse * rate * width)
    assert -sums.slope_integral(x) == pytest.approx(sums.integral(speed), abs=4 * coarse * width)
    by_parts = -sums.slope_along(np.ones_like(x), x)
    assert by_parts == pytest.approx(-sums.integral(rate**2 * x), abs=10 * coarse * rate)


def test_noise_averages_out():
    """White noise of positions enters by the bump's slope: its variance is step / width times what it would be if the
    bump were sampled at its ends alone."""
    time = 0.01 * np.arange(200_000)
    random = np.random.default_rng(0)
    sums = Bumps.over(time, 1.0).on(time)
    found = sums.along(np.ones_like(time), random.standard_normal(len(time)))
    slope = quad(lambda s: (8 * s * (1 - s**2) ** 3) ** 2, -1, 1)[0] / 0.5
    assert found.std() == pytest.approx(np.sqrt(0.01 * slope), rel=0.05)


@given(st.integers(100, 700), st.integers(30, 150))
def test_a_hole_is_no_measurement(first, rows):
    time = np.delete(0.01 * np.arange(900), slice(first, first + rows))
    bumps = Bumps.over(time, 1.0)
    sums = bumps.on(time)
    start, stop = 0.01 * (first - 1), 0.01 * (first + rows)
    apart = (bumps.centres + 0.5 <= start + 1e-9) | (bumps.centres - 0.5 >= stop - 1e-9)
    assert np.array_equal(sums.covered, apart)


def test_a_log_shorter_than_a_bump_has_none():
    assert len(Bumps.over(np.array([0.0, 0.5]), 1.0).centres) == 0
