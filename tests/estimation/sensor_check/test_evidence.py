"""Evidence of gains by quadrature, rows that count by what means of coloured noise do, and windows by integrals."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from estimation.sensor_check.evidence import gain_evidence, gross_error_probability, independent_rows, probabilities
from estimation.sensor_check.windows import Windows

SEEDS = st.integers(0, 2**32 - 1)


@given(st.floats(0.05, 20.0), st.floats(0.5, 0.99), st.floats(20.0, 80.0), st.floats(-2.0, 2.0), st.floats(0.2, 2.0))
def test_evidence_is_the_integral_it_stands_for(size, share, rows, mean, spread):
    """Up to what all rivals have in common. A normal peak is exact; these are skewed, so to a nat, where the prior is
    within three of its deviations."""
    yy, zz = 4.0, size
    zy = share * np.sqrt(yy * zz)
    mean = np.log(zy / zz) + mean * spread
    log_gain = np.linspace(mean - 10 * spread, mean + 10 * spread, 20001)
    left = (yy - 2 * np.exp(log_gain) * zy + np.exp(2 * log_gain) * zz) / yy + 0.01
    height = -0.5 * rows * np.log(left) + norm.logpdf(log_gain, mean, spread)
    top = height.max()
    wanted = top + np.log(np.trapezoid(np.exp(height - top), log_gain))
    found, best = gain_evidence((np.array([zz]), np.array([zy]), yy), rows, np.array([mean]), spread, 0.01)
    assert found[0] == pytest.approx(wanted, abs=1.0)
    assert np.exp(best[0]) == pytest.approx(zy / zz)


@given(st.floats(0.0, 0.8), SEEDS)
def test_rows_that_count(keep, seed):
    """Of an autoregression n (1 - keep) / (1 + keep) count: the variance of the mean is that of so many white ones."""
    random, n = np.random.default_rng(seed), 4000
    noise = random.standard_normal(n)
    for i in range(1, n):
        noise[i] = keep * noise[i - 1] + np.sqrt(1 - keep**2) * noise[i]
    assert independent_rows(noise) == pytest.approx(n * (1 - keep) / (1 + keep), rel=0.35)


@given(st.lists(st.floats(-1e5, 1e5), min_size=2, max_size=6))
def test_probabilities_add_up(logs):
    found = probabilities(np.array(logs), np.ones(len(logs)))
    assert found.sum() == pytest.approx(1.0)


@given(st.floats(-0.2, 0.2), st.floats(1e-4, 0.1))
def test_what_is_wider_is_bayes_rule(value, std):
    sound, wrong, odds = 0.002, 0.05, 0.2
    wide = odds * norm.pdf(value, 0, np.hypot(std, wrong))
    narrow = norm.pdf(value, 0, np.hypot(std, sound))
    assert gross_error_probability(value, std, sound, wrong, odds) == pytest.approx(wide / (wide + narrow), abs=1e-9)


@given(SEEDS, st.floats(0.1, 3.0), st.floats(-0.1, 0.1))
def test_windows_integrate_and_need_no_derivative(seed, rate, late):
    """Of times that are uneven by a half: what rates of change x' give, displacements and slopes give, too."""
    random = np.random.default_rng(seed)
    time = np.cumsum(0.01 * random.uniform(0.5, 1.5, 900))
    sums = Windows.over(time).on(time, late)
    x, speed = np.sin(rate * time), rate * np.cos(rate * time)
    kept = sums.covered
    assert kept.sum() > 40
    by_speed = sums.integral(speed)[kept]
    assert sums.along(x)[kept] == pytest.approx(by_speed, abs=2e-5 * rate)
    assert sums.rate(x)[kept][:-1] == pytest.approx(by_speed[:-1], abs=2e-3)  # the last one is cut off a little


@given(st.integers(100, 700), st.integers(30, 150))
def test_a_hole_is_no_measurement(first, rows):
    """Windows of 0.8 s whose middle lies in a hole are not covered, those a window away are."""
    time = np.delete(0.01 * np.arange(900), slice(first, first + rows))
    windows = Windows.over(time)
    covered = windows.on(time).covered
    middle = windows.first + windows.step * (np.arange(len(covered)) + 2.5)
    start, stop = 0.01 * first, 0.01 * (first + rows)
    assert not covered[(middle > start) & (middle < stop)].any()
    assert covered[(middle + 0.4 < start) | (middle - 0.4 > stop)].all()


def test_too_few_or_too_slow_samples_have_no_windows():
    assert Windows.over(np.linspace(0.0, 0.5, 50)) is None
    assert Windows.over(np.arange(0.0, 100.0, 0.5)) is None
