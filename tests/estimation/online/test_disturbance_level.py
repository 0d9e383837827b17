"""The level of disturbances that rows tell, by rows drawn at a known level."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimation.online.regressor.disturbance_level import N_DISTURBANCE_LEVELS, DisturbanceLevel
from estimation.online.regressor.regression_belief import Innovation

LOW, HIGH = 0.05, 2.0
ONE = np.diag([3.0, 0.4])
"""What one density does to a row's covariance, and what else is in it."""
ELSE = np.array([[0.02, 0.001], [0.001, 0.004]])


def innovation(value, density=HIGH**2):
    spread = ELSE + density * ONE
    return Innovation(
        0.0, np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0)), value, spread, spread, (value, spread, spread), 0.0 * ONE
    )


@settings(max_examples=30, deadline=None)
@given(root=st.floats(LOW, HIGH), seed=st.integers(0, 2**32 - 1))
def test_it_finds_the_level_at_which_rows_are_drawn(root, seed):
    rows = np.random.default_rng(seed).multivariate_normal(np.zeros(2), ELSE + root**2 * ONE, 300)
    level = DisturbanceLevel.between(LOW, HIGH)
    for row in rows:
        level = level.after(innovation(row), ONE)
    step = (HIGH / LOW) ** (1.0 / (N_DISTURBANCE_LEVELS - 1))
    assert root / (1.3 * step) < np.sqrt(level.mean_density) < root * 1.3 * step


def test_likelihoods_are_those_of_each_alone():
    told = innovation(np.array([0.3, -0.1]))
    more = np.linspace(0.1, 3.0, 4)[:, None, None] * ONE
    np.testing.assert_allclose(told.log_likelihoods(more), [told.log_likelihood(more=one) for one in more], rtol=1e-12)
    value, spread = told.value, told.covariance
    by_hand = -0.5 * (value @ np.linalg.inv(spread) @ value + np.log(np.linalg.det(spread)))
    assert told.log_likelihood() == pytest.approx(by_hand)


def test_where_nothing_louder_is_borne_with_there_is_one_level():
    level = DisturbanceLevel.between(0.5, 0.2)
    assert level.mean_density == level.highest == 0.25
    assert level.after(innovation(np.zeros(2)), ONE) is level
