"""The compiled proof says what the numpy one says, of right answers and of wrong ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from planning.allocation.duality import infeasible_by
from planning.kernels import loading, proof
from planning.kernels.workspace import Sizes, views
from planning.quadratic_program import QPSolution, verify
from tests.kernels_called import called

from ..dual_active_set_solver import DualActiveSetSolver
from ..solvers.test_solvers import program_of, random_program

VERIFY, RAY_VALUE = called(proof.verify), called(proof.ray_value)


def claim_of(program, x, y):
    workspace = views(*Sizes(program.n, len(program.upper), program.n_equalities).allocate())
    loading.load(workspace, program)
    loading.load_spans(workspace, workspace.problem.rows != 0)
    workspace.claim.x[:], workspace.claim.y[:] = x, y
    return workspace


def both(program, x, y):
    """Residuals by numpy and by the kernel, and whether each calls them proven."""
    workspace, ours = claim_of(program, x, y), verify(program, x, y)
    proven = VERIFY(workspace.claim, workspace.found)
    return list(ours), workspace.found[:7].tolist(), ours.proven, proven


@pytest.mark.long
@settings(max_examples=100)
@given(st.integers(0, 10**6), st.sampled_from([0.0, 1e-10, 1e-6, 1.0]))
def test_residuals_are_those_of_numpy(seed, error):
    rng = np.random.default_rng(seed)
    program = random_program(rng)
    solution = DualActiveSetSolver().solve(program)
    x = solution.x + error * rng.normal(size=program.n)
    y = solution.multipliers + error * rng.normal(size=len(program.upper)) * (rng.random(len(program.upper)) < 0.5)
    numpy_says, kernel_says, proven, compiled_proven = both(program, x, y)
    scale = 1.0 + np.abs(x).max() ** 2 + np.abs(y).max() * (1 + np.abs(x).max())
    assert kernel_says == pytest.approx(numpy_says, rel=1e-9, abs=1e-12 * scale)
    assert compiled_proven == proven or error not in (0.0, 1.0)


@pytest.mark.parametrize("where", ["x", "y", "gradient", "hessian", "rows", "limits"])
@pytest.mark.parametrize("index", [0, -1])
def test_nothing_is_proven_of_nan(where, index):
    program = program_of(np.eye(2), [0, 0], [[1, 0], [1, 1]], [-5, -5, -2, 3], [1, 5, 2, 3], 1)
    solution = DualActiveSetSolver().solve(program)
    workspace = claim_of(program, solution.x, solution.multipliers)
    assert VERIFY(workspace.claim, workspace.found)
    spoiled = getattr(workspace.claim, where)
    spoiled.flat[index] = np.nan
    if where == "y" and index == 0:
        assert solution.multipliers[0] != 0.0
    assert not VERIFY(workspace.claim, workspace.found)


@pytest.mark.parametrize("seed", range(30))
def test_the_value_of_a_ray_is_that_of_numpy(seed):
    rng = np.random.default_rng(seed)
    program = random_program(rng)
    y = rng.normal(size=len(program.upper))
    if program.n_equalities == 0:
        return
    workspace = claim_of(program, np.zeros(program.n), y)
    nothing = QPSolution.failed(program, "infeasible", "", "")
    ray = QPSolution("infeasible", np.zeros(program.n), y, (), nothing.residuals, np.inf, "")
    slack = y[len(y) - program.n_equalities :]
    assert RAY_VALUE(workspace.claim) == pytest.approx(infeasible_by(program, ray, slack), rel=1e-9)


def test_views_fill_the_workspace_and_do_not_overlap():
    floats, ints = Sizes(12, 30, 2, 2, 3, 2).allocate()
    workspace = views(floats, ints)
    parts = [*workspace.problem, *workspace.held, *workspace.claim, *workspace[3:]]
    arrays = {a.__array_interface__["data"][0]: a for a in parts if isinstance(a, np.ndarray)}
    assert sum(a.size for a in arrays.values()) == len(floats) + len(ints) - 6
    for number, a in enumerate(arrays.values()):
        a[...] = number
    assert all((a == number).all() for number, a in enumerate(arrays.values()))
