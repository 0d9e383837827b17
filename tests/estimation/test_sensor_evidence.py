"""Evidence of gains by quadrature, and rows that count by what means of coloured noise do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from estimation.sensor_check.evidence import from_odds, gain_evidence, independent_rows, probabilities


@given(
    size=st.floats(0.05, 20.0),
    share=st.floats(-0.9, 0.99),
    rows=st.floats(10.0, 80.0),
    mean=st.floats(-2.0, 2.0),
    spread=st.floats(0.2, 2.0),
)
def test_evidence_is_the_integral_it_stands_for(size, share, rows, mean, spread):
    """Laplace's method is exact for a normal peak; these are skewed, so to a third of a nat."""
    yy, zz = 4.0, size
    zy = share * np.sqrt(yy * zz)

    def height(log_gain):
        left = yy - 2 * np.exp(log_gain) * zy + np.exp(2 * log_gain) * zz + 0.01 * yy
        return -0.5 * rows * np.log(left) + norm.logpdf(log_gain, mean, spread)

    grid = np.linspace(mean - 10 * spread, mean + 10 * spread, 4001)
    top = max(height(one) for one in grid)
    wanted = top + np.log(np.trapezoid([np.exp(height(one) - top) for one in grid], grid))
    found, log_gain, deviation = gain_evidence((np.array([zz]), np.array([zy]), yy), rows, np.array(mean), spread, 0.01)
    assert found[0] == pytest.approx(wanted, abs=0.35)
    assert height(log_gain[0]) == pytest.approx(top, abs=0.01)
    assert 0 < deviation[0] <= spread * 1.01


@given(st.floats(0.0, 0.8), st.integers(0, 2**32 - 1))
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
    assert found.argmax() == np.argmax(logs) or found.max() == pytest.approx(found[np.argmax(logs)])


def test_odds():
    assert from_odds(0.0) == 0.5
    assert from_odds(np.log(9.0)) == pytest.approx(0.9)
    assert 0.0 <= from_odds(-1e9) < from_odds(1e9) <= 1.0
