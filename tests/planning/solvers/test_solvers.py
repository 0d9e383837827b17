"""Every solver sits the same exam: allocation programs and general ones, easy, degenerate and infeasible."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from qpsolvers import available_solvers
from scipy.optimize import linprog

from planning.allocation.allocation import build_allocation
from planning.quadratic_program import QuadraticProgram
from planning.solvers import QuadraticSolver, solve_with_clarabel
from planning.solvers.daqp_solver import DaqpSolver

from ..drawn import first_contacts, largest_scale, random_arms, random_cart
from ..dual_active_set_solver import DualActiveSetSolver
from ..reference_allocation import solve_reference


class Clarabel:
    def solve(self, program):
        return solve_with_clarabel(program)


def named(name):
    def make():
        return QuadraticSolver(name=name)

    make.__name__ = name
    return make


SOLVERS = [QuadraticSolver, DaqpSolver, DualActiveSetSolver, Clarabel, *map(named, available_solvers)]
each_solver = pytest.mark.parametrize("make", SOLVERS, ids=lambda make: make.__name__)


def program_of(hessian, gradient, rows, lower, upper, n_equalities=0):
    names = tuple(str(i) for i in range(len(upper)))
    arrays = (np.asarray(a, dtype=float) for a in (hessian, gradient, rows, lower, upper))
    return QuadraticProgram(*arrays, n_equalities, names, names)


def random_program(rng):
    """Dense, with limits on both sides, some missing, some equal, and rows that depend on others."""
    n, m, equalities = int(rng.integers(2, 9)), int(rng.integers(1, 12)), int(rng.integers(0, 3))
    root = rng.normal(size=(n, n))
    rows = rng.normal(size=(m + equalities, n)) * (rng.random((m + equalities, n)) < 0.6)
    if m > 2:
        rows[1] = -2.0 * rows[0]
    values = np.concatenate([np.zeros(n), rows @ np.zeros(n)]) + rng.normal(size=n + len(rows))
    below, above = rng.exponential(1.0, (2, n + len(rows)))
    below[rng.random(len(below)) < 0.3] = np.inf
    above[rng.random(len(above)) < 0.3] = np.inf
    lower, upper = values - below, values + above
    lower[n + m :] = upper[n + m :] = values[n + m :]
    hessian = root @ root.T + 0.1 * np.eye(n)
    return program_of(hessian, 3 * rng.normal(size=n), rows, lower, upper, equalities)


def oracle(program):
    """0 if HiGHS finds a point, 2 if it proves that there is none."""
    A, b = program.equality
    rows, low, high = program.inequality
    G, h = np.vstack([rows, -rows]), np.concatenate([high, -low])
    held = np.isfinite(h)
    bounds = [(None if a == -np.inf else a, None if c == np.inf else c) for a, c in zip(*program.bounds, strict=True)]
    return linprog(np.zeros(program.n), G[held], h[held], A, b, bounds=bounds, method="highs").status


@each_solver
def test_a_program_solved_by_hand(make):
    """min x² + y² with x + y = 3, x <= 1: x = 1, y = 2, pushed down at x's upper limit by 2."""
    program = program_of(2 * np.eye(2), [0, 0], [[1, 1]], [-5, -5, 3], [1, 5, 3], 1)
    solution = make().solve(program)
    assert solution.status == "optimal"
    assert solution.x == pytest.approx([1, 2], abs=1e-9)
    assert solution.multipliers == pytest.approx([2, 0, -4], abs=1e-8)
    assert solution.cost == pytest.approx(5)


@pytest.mark.some(120)
@each_solver
@pytest.mark.parametrize("seed", range(40))
def test_general_programs_against_cvxpy_and_highs(make, seed):
    program = random_program(np.random.default_rng(seed))
    solution, feasible = make().solve(program), oracle(program) == 0
    assert solution.status == ("optimal" if feasible else "infeasible")
    if feasible:
        reference = solve_reference(program)
        assert solution.cost == pytest.approx(reference.cost, rel=1e-7, abs=1e-7)
        assert solution.x == pytest.approx(reference.x, abs=1e-4)


@pytest.mark.some(75)
@each_solver
@pytest.mark.parametrize("seed", range(25))
def test_allocations_against_highs(make, seed):
    rng = np.random.default_rng(seed)
    model, arms = random_cart(rng), random_arms(rng, int(rng.integers(1, 5)))
    wrench = rng.uniform((0, -20, -12), (120, 20, 12))
    program = build_allocation(model, arms, first_contacts(arms), wrench)
    solution = make().solve(program)
    assert solution.status == {0: "optimal", 2: "infeasible"}[oracle(program)]


@pytest.mark.some(60)
@each_solver
@pytest.mark.parametrize("seed", range(20))
def test_just_inside_and_just_outside_of_what_arms_can_do(make, seed):
    rng = np.random.default_rng(seed)
    model, arms = random_cart(rng), random_arms(rng, int(rng.integers(1, 5)))
    contacts, wrench = first_contacts(arms), rng.uniform((5, -10, -4), (40, 10, 4))
    most = largest_scale(model, arms, contacts, wrench)
    if not 1e-9 < most < np.inf:
        return
    for share, status in ((1 - 1e-6, "optimal"), (1 + 1e-6, "infeasible")):
        program = build_allocation(model, arms, contacts, share * most * wrench)
        assert make().solve(program).status in (status, "numerical")
        if make in (QuadraticSolver, DualActiveSetSolver):
            assert make().solve(program).status == status


@pytest.mark.parametrize("seed", range(60))
def test_three_solvers_agree_to_rounding(seed):
    rng = np.random.default_rng(seed)
    model, arms = random_cart(rng), random_arms(rng, int(rng.integers(1, 5)))
    program = build_allocation(model, arms, first_contacts(arms), rng.uniform((0, -5, -4), (30, 5, 4)))
    one, *others = (make().solve(program) for make in (DualActiveSetSolver, DaqpSolver, Clarabel))
    for other in others:
        assert one.status == other.status
        if one.status == "optimal":
            assert one.cost == pytest.approx(other.cost, rel=1e-9, abs=1e-9)
            assert one.x == pytest.approx(other.x, abs=1e-7)


@pytest.mark.parametrize("make", [DaqpSolver, DualActiveSetSolver])
def test_warm_equals_cold(make):
    """Only the equality's value changes, from feasible to infeasible and back."""
    rng = np.random.default_rng(3)
    arms, model = random_arms(rng, 3, sides=4), random_cart(rng)
    warm, first = make(), build_allocation(model, arms, first_contacts(arms), (10, 0, 0))
    for _ in range(200):
        asked = build_allocation(model, arms, first_contacts(arms), rng.uniform((0, 0, -9), (120, 0, 9)))
        program = first.with_equality_value(asked.equality[1])
        one, other = warm.solve(program), make().solve(program)
        assert one.status == other.status
        assert one.x == pytest.approx(other.x, abs=1e-8)


@each_solver
def test_limits_that_meet_in_a_corner_or_twice(make):
    """Six limits through the optimum in a plane, one of them twice."""
    angles = np.linspace(0, 1.5, 5)
    rows = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rows = np.vstack([rows, rows[:1]])
    top = rows @ [1.0, 1.0]
    program = program_of(np.eye(2), [-3, -3], rows, [-np.inf] * 8, [1, 1, *top])
    solution = make().solve(program)
    assert solution.status == "optimal"
    assert solution.x == pytest.approx([1, 1], abs=1e-8)


@each_solver
def test_equalities_that_repeat_or_contradict_each_other(make):
    same = program_of(np.eye(2), [0, 0], [[1, 1], [2, 2]], [-9, -9, 2, 4], [9, 9, 2, 4], 2)
    assert make().solve(same).status != "infeasible"
    against = replace(same, lower=np.array([-9, -9, 2, 5.0]), upper=np.array([9, 9, 2, 5.0]))
    assert make().solve(against).status != "optimal"


def test_the_compiled_solver_repeats_an_equality():
    same = program_of(np.eye(2), [0, 0], [[1, 1], [2, 2]], [-9, -9, 2, 4], [9, 9, 2, 4], 2)
    assert DualActiveSetSolver().solve(same).x == pytest.approx([1, 1])
    against = replace(same, lower=np.array([-9, -9, 2, 5.0]), upper=np.array([9, 9, 2, 5.0]))
    assert DualActiveSetSolver().solve(against).status == "infeasible"


@pytest.mark.parametrize("hessian", [np.diag([1.0, 0.0]), np.diag([1.0, -1.0]), np.diag([1.0, np.nan])])
def test_the_compiled_solver_refuses_what_is_not_strictly_convex(hessian):
    program = program_of(hessian, [0, 0], [[1, 1]], [-5, -5, 3], [1, 5, 3], 1)
    solution = DualActiveSetSolver().solve(program)
    assert solution.status == "numerical"
    assert "strictly convex" in solution.message


@pytest.mark.parametrize("field", ["gradient", "rows", "lower", "upper"])
def test_the_compiled_solver_says_nothing_of_nan(field):
    program = program_of(np.eye(2), [0, 0], [[1, 1]], [-5, -5, 3], [1, 5, 3], 1)
    spoiled = getattr(program, field).copy()
    spoiled.flat[0] = np.nan
    assert DualActiveSetSolver().solve(replace(program, **{field: spoiled})).status == "numerical"


@pytest.mark.prove
def test_three_solvers_agree_on_2000_programs():
    for seed in range(2000):
        rng = np.random.default_rng(seed)
        model, arms = random_cart(rng), random_arms(rng, int(rng.integers(1, 5)))
        program = build_allocation(model, arms, first_contacts(arms), rng.uniform((0, -9, -9), (90, 9, 9)))
        found = [make().solve(program) for make in (DualActiveSetSolver, DaqpSolver, Clarabel)]
        assert len({solution.status for solution in found}) == 1, seed
        if found[0].status == "optimal":
            assert np.ptp([solution.cost for solution in found]) <= 1e-7 * max(1.0, abs(found[0].cost)), seed
