"""Three solvers of three kinds find one optimum: the planner (daqp, active set), Clarabel (interior point) and OSQP
(operator splitting, polished). The others get the program as the test writes it down, not as `planning` does."""

from __future__ import annotations

import numpy as np
import pytest
from qpsolvers import Problem, solve_problem
from scipy.sparse import csc_matrix

from planning import WrenchPlanner

from ..drawn import effective_matrix, first_contacts, largest_scale, linear_limits, random_arms, random_cart

# qpsolvers calls OSQP in a way that OSQP will change its answer to.
pytestmark = pytest.mark.filterwarnings("ignore:The default value of raise_error:PendingDeprecationWarning")

SETTINGS = {
    "clarabel": {"tol_gap_abs": 1e-11, "tol_gap_rel": 1e-11, "tol_feas": 1e-11},
    "osqp": {"eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 100_000, "polishing": True, "polish_refine_iter": 10},
}
AGREE = 1e-7  # of the objective, relative above 1


def written_down(model, arms, contacts, wrench):
    """The allocation as `minimise 1/2 x'Px such that G x <= h, A x = b, lb <= x <= ub`."""
    rows, limits, bounds = linear_limits(arms)
    weights = 2 * np.concatenate([a.weights for a in arms])
    lower = np.array([-np.inf if low is None else low for low, _ in bounds])
    upper = np.array([np.inf if high is None else high for _, high in bounds])
    equality, target = effective_matrix(model, arms, contacts), model.constraints.basis_b.T @ wrench
    inequality = (csc_matrix(rows), limits) if len(rows) else (None, None)
    hessian, zero = csc_matrix(np.diag(weights)), np.zeros(len(weights))
    return Problem(hessian, zero, *inequality, csc_matrix(equality), target, lower, upper)


def draw(rng):
    """A feasible problem: a wrench at 0.05 to 0.95 of what the arms can do, or at all where they can do anything."""
    while True:
        model, arms = random_cart(rng), random_arms(rng, int(rng.integers(1, 5)))
        contacts, wrench = first_contacts(arms), rng.uniform((-5, -20, -12), (80, 20, 12))
        largest = largest_scale(model, arms, contacts, wrench)
        if largest > 1e-3:
            share = rng.uniform(0.05, 0.95)
            return model, arms, contacts, wrench * (share * largest if np.isfinite(largest) else 1.0)


def objectives(rng):
    """Of the planner, and of its peers by name."""
    model, arms, contacts, wrench = draw(rng)
    plan = WrenchPlanner(model, arms).plan(wrench, contacts)
    assert plan.status == "optimal"
    found = {}
    for name in SETTINGS:
        problem = written_down(model, arms, contacts, wrench)
        solution = solve_problem(problem, solver=name, **SETTINGS[name])
        assert solution.found, name
        found[name] = float(0.5 * solution.x @ (problem.P @ solution.x))
    return plan.effort, found


def compare(seed, n):
    """The largest difference of each peer over n problems."""
    rng, worst = np.random.default_rng(seed), dict.fromkeys(SETTINGS, 0.0)
    for _ in range(n):
        ours, others = objectives(rng)
        for name, theirs in others.items():
            difference = abs(ours - theirs) / max(1.0, abs(ours))
            assert difference <= AGREE, (name, ours, theirs)
            worst[name] = max(worst[name], difference)
    return worst


def test_three_solvers_agree():
    assert set(compare(0, 40)) == set(SETTINGS)


@pytest.mark.prove
@pytest.mark.parametrize("seed", range(1, 5))
def test_three_solvers_agree_on_two_thousand(seed, record_property):
    for name, difference in compare(seed, 500).items():
        record_property(name, difference)
