"""The most likely parameters that a cart can have, by searches and other solvers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear, minimize

from cartgrasp.inertia import phi_from_physical
from estimation import physical_set
from estimation.physical_set import PhysicalSet

from .whole_log.test_identification import DRAGS, guess


def projected(parameters, information, least):
    """The nearest physical parameters by a search over mass, CoM and inertia, which keep within bounds there."""

    def cost(physical):
        miss = phi_from_physical(*physical) - parameters
        return miss @ information @ miss

    starts = [(5.0, 0.1, 0.1, 1.0), (10.0, 0.3, -0.2, least[1]), (2.0, 0.0, 0.0, 3.0)]
    bounds = [(least[0], None), (None, None), (None, None), (least[1], None)]
    tried = [minimize(cost, start, bounds=bounds, tol=1e-14, options={"maxiter": 5000}) for start in starts]
    return phi_from_physical(*min(tried, key=lambda one: one.fun).x)


@pytest.mark.parametrize("seed", range(4))
def test_the_nearest_body_is_that_of_a_search(seed):
    random = np.random.default_rng(seed)
    cart = guess(effects=())
    limits = PhysicalSet.of(cart, "a test")
    parameters = np.array([8.0, 6.0, -4.0, 2.0]) + random.standard_normal(4)
    root = random.standard_normal((4, 4)) + 2 * np.eye(4)
    information = root @ root.T
    assert not limits.holds(parameters)
    nearest = limits.nearest(parameters, np.arange(4), information)
    assert limits.holds(nearest)
    assert nearest == pytest.approx(projected(parameters, information, (2.0, 0.09)), abs=3e-3)


@given(st.integers(0, 2**32 - 1))
def test_the_least_step_within_bounds_is_that_of_another_solver(seed):
    random = np.random.default_rng(seed)
    root = random.standard_normal((5, 5))
    metric, low = root @ root.T + 0.1 * np.eye(5), random.normal(-0.5, 1.0, 5)
    high = low + random.exponential(2.0, 5)
    low[0], high[1] = -np.inf, np.inf
    expected = lsq_linear(np.linalg.cholesky(metric).T, np.zeros(5), (low, high), method="bvls").x
    assert physical_set._least(metric, low, high) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_the_nearest_within_bounds_is_that_of_a_search(seed):
    random = np.random.default_rng(seed)
    cart = guess(effects=DRAGS)
    limits = PhysicalSet.of(cart, "a test")
    parameters = cart.parameters + np.array([0.5, 0.1, 0.1, 1.0, -6.0, 0.3, -0.01]) * random.uniform(0.5, 1.0, 7)
    root = random.standard_normal((7, 7)) + 3 * np.eye(7)
    information = root @ root.T
    nearest = limits.nearest(parameters, np.arange(7), information)
    bounds = [(None, None)] * 4 + [(0.0, None)] * 2 + [(0.0, 1.0)]
    found = minimize(
        lambda p: (p - parameters) @ information @ (p - parameters), cart.parameters, bounds=bounds, tol=1e-12
    )
    assert limits.holds(nearest)
    assert nearest == pytest.approx(found.x, abs=2e-4)
