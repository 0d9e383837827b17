"""The proof of a solution must fail when any part of it is wrong, and each solver must pass it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cartgrasp.arms import Friction
from planning.allocation.allocation import build_allocation
from planning.allocation.duality import infeasible_by
from planning.allocation.projection import project, projection_program
from planning.quadratic_program import Cone, QuadraticProgram, verify
from planning.solvers import QuadraticSolver, solve_with_clarabel
from planning.solvers.polish import polish

from .drawn import arm, cart, first_contacts, largest_scale, random_arms, random_cart, replace_friction
from .reference_allocation import solve_reference


def simple_program():
    """min x² + y² with x + y = 3, x <= 1: x = 1, y = 2, pushed down at x's upper limit by 2."""
    return QuadraticProgram(
        hessian=2 * np.eye(2),
        gradient=np.zeros(2),
        rows=np.array([[1.0, 1.0]]),
        lower=np.array([-5.0, -5.0, 3.0]),
        upper=np.array([1.0, 5.0, 3.0]),
        n_equalities=1,
        lower_names=("x lower", "y lower", "sum"),
        upper_names=("x upper", "y upper", "sum"),
    )


def test_a_program_solved_by_hand():
    program = simple_program()
    solution = QuadraticSolver().solve(program)
    assert solution.x == pytest.approx([1, 2], abs=1e-12)
    assert solution.multipliers == pytest.approx([2, 0, -4], abs=1e-12)
    assert solution.cost == pytest.approx(5)
    assert program.active(solution) == ("x upper",)
    noisy = replace(solution, multipliers=np.array([2.0, 1e-12, -4.0]))
    assert program.active(noisy) == ("x upper",)
    assert solution.residuals.proven


@pytest.mark.parametrize(
    ("x", "y", "part"),
    [
        ([1.0, 2.0 + 1e-6], [2, 0, -4], "equality"),
        ([1.0 + 1e-6, 2.0 - 1e-6], [2, 0, -4], "limits"),
        ([1.0, 2.0], [2 + 1e-5, 0, -4], "stationarity"),
        ([0.0, 3.0], [6, 0, -6], "gap"),  # stationary, but pays for a limit that isn't touched
        ([1.5, 1.5], [0, 0, -3], "limits"),
    ],
)
def test_each_part_of_the_proof_can_fail(x, y, part):
    program = simple_program()
    x, y = np.array(x), np.array(y, dtype=float)
    residuals = verify(program, x, y)
    assert residuals.as_dict()[part] > 1e-7
    assert not residuals.proven


@pytest.mark.parametrize("y", [[np.inf, 0, -np.inf], [np.nan, 0, -4], [2, 0, np.nan], [1e308, 1e308, -1e308]])
def test_multipliers_that_a_solver_lost_prove_nothing(y):
    assert not verify(simple_program(), np.array([0.5, 2.5]), np.array(y, dtype=float)).proven


def test_a_multiplier_of_the_wrong_sign_hides_nothing():
    """Without a lower limit nothing can push up: a negative multiplier there counts as zero."""
    program = replace(simple_program(), lower=np.array([-np.inf, -np.inf, 3.0]))
    wrong = verify(program, np.array([0.0, 3.0]), np.array([6.0, 0.0, -6.0]))
    assert wrong.gap > 0.1
    pulled = verify(program, np.array([1.0, 2.0]), np.array([-2.0, 0.0, -4.0]))
    assert pulled.stationarity == pytest.approx(2.0)  # it would be 4 with what can't push
    assert pulled.gap == pytest.approx(0.0)


def test_a_cone_multiplier_outside_the_cone_hides_nothing():
    cone = Cone("cone", np.eye(2), np.zeros(2))
    program = replace(simple_program(), cones=(cone,))
    x, y = np.array([1.0, 2.0]), np.array([2.0, 0.0, -4.0])
    assert verify(program, x, y, [np.zeros(2)]).limits == pytest.approx(1.0)
    assert verify(program, x, y, [np.array([0.0, 1.0])]).stationarity >= 1.0


@pytest.mark.parametrize("seed", range(60))
def test_daqp_agrees_with_cvxpy(seed):
    rng = np.random.default_rng(seed)
    model, arms = random_cart(rng), random_arms(rng, int(rng.integers(1, 4)))
    contacts, wrench = first_contacts(arms), rng.uniform((5, -10, -4), (40, 10, 4))
    scale = min(1.0, largest_scale(model, arms, contacts, wrench))
    wrench = wrench * scale * rng.choice([0.3, 0.9, 1 - 1e-6])  # near the limit of what they can do
    program = build_allocation(model, arms, contacts, wrench)
    solution, reference = QuadraticSolver().solve(program), solve_reference(program)
    assert solution.status == "optimal"
    assert solution.cost == pytest.approx(reference.cost, rel=1e-7, abs=1e-7)
    assert solution.x == pytest.approx(reference.x, abs=2e-4)
    assert solution.residuals.equality <= 1e-9
    assert solution.residuals.limits <= 1e-9


@pytest.mark.parametrize("seed", range(25))
def test_clarabel_agrees_with_daqp_to_rounding(seed):
    rng = np.random.default_rng(seed)
    model, arms = random_cart(rng), random_arms(rng, 2)
    contacts, wrench = first_contacts(arms), rng.uniform((5, -10, -4), (40, 10, 4))
    wrench = wrench * min(1.0, 0.95 * largest_scale(model, arms, contacts, wrench))
    program = build_allocation(model, arms, contacts, wrench)
    fast, slow = QuadraticSolver().solve(program), solve_with_clarabel(program)
    assert fast.status == slow.status == "optimal"
    assert fast.x == pytest.approx(slow.x, abs=1e-8)


@pytest.mark.parametrize("seed", range(25))
def test_cones_agree_with_cvxpy(seed):
    rng = np.random.default_rng(seed)
    model, arms = random_cart(rng), random_arms(rng, 2, sides="exact")
    fine = [replace_friction(a, Friction(a.friction.mu, 32)) for a in arms]
    contacts, wrench = first_contacts(arms), rng.uniform((5, -10, -4), (40, 10, 4))
    wrench = wrench * min(1.0, 0.9 * largest_scale(model, fine, contacts, wrench))
    program = build_allocation(model, arms, contacts, wrench)
    solution, reference = QuadraticSolver().solve(program), solve_reference(program)
    assert solution.status == "optimal"
    assert solution.cost == pytest.approx(reference.cost, rel=1e-7, abs=1e-7)
    assert max(solution.residuals.equality, solution.residuals.limits) <= 1e-9


@pytest.mark.parametrize("seed", range(10))
def test_weights_of_zero(seed):
    """A singular Hessian: the cost is unique though the wrenches may not be."""
    rng = np.random.default_rng(seed)
    arms = [arm(f"arm{i}", [rng.uniform(-0.4, 0.4, 3)], weights=rng.choice([0.0, 1.0, 5.0], 6)) for i in range(2)]
    program = build_allocation(cart(), arms, first_contacts(arms), (30, 0, 4))
    solution, reference = QuadraticSolver().solve(program), solve_reference(program)
    assert solution.status == "optimal"
    assert solution.cost == pytest.approx(reference.cost, rel=1e-6, abs=1e-6)
    assert max(solution.residuals.equality, solution.residuals.limits) <= 1e-9


def test_warm_solves_equal_cold_ones():
    rng = np.random.default_rng(5)
    arms = random_arms(rng, 3, sides=4)
    warm = QuadraticSolver()
    for _ in range(200):
        contacts = {a.name: rng.uniform(-0.5, 0.5, 3) for a in arms}
        program = build_allocation(cart(), arms, contacts, rng.uniform((0, 0, -9), (150, 0, 9)))
        one, other = warm.solve(program), QuadraticSolver().solve(program)
        assert one.status == other.status
        assert one.x == pytest.approx(other.x, abs=1e-8)


def test_polish_mends_a_rough_solution():
    arms = [arm("left", friction=Friction(0.3)), arm("right", [(-0.25, -0.2, 1.0)])]
    program = build_allocation(cart(), arms, first_contacts(arms), (40, 0, 12))
    exact = QuadraticSolver().solve(program)
    rng = np.random.default_rng(0)
    y = exact.multipliers + 1e-5 * rng.normal(size=len(exact.multipliers)) * (exact.multipliers != 0)
    rough = replace(exact, x=exact.x + 1e-5 * rng.normal(size=12), multipliers=y, status="numerical")
    assert verify(program, rough.x, rough.multipliers).equality > 1e-7
    assert verify(program, rough.x, rough.multipliers).stationarity > 1e-7
    mended = polish(program, rough)
    assert mended.status == "optimal"
    assert mended.x == pytest.approx(exact.x, abs=1e-10)


def test_polish_follows_the_curvature_of_a_cone():
    friction = Friction(0.2, "exact")
    a = arm("left", [(-0.5, 0.1, 1.0)], friction=friction, yaw=0.3, moment_limit=(20, 20, 20))
    program = build_allocation(cart(), [a], first_contacts([a]), (20, 0, 8))
    exact = solve_with_clarabel(program)
    assert program.active(exact) == ("left: friction cone",)
    rng = np.random.default_rng(0)
    z = tuple(m * (1 + 1e-3 * rng.normal(size=3)) for m in exact.cone_multipliers)
    rough = replace(exact, x=exact.x + 3e-2 * rng.normal(size=6), cone_multipliers=z, status="numerical")
    mended = polish(program, rough)
    assert mended.status == "optimal"
    assert mended.x == pytest.approx(exact.x, abs=1e-8)


@pytest.mark.parametrize("seed", range(20))
def test_no_multipliers_prove_a_feasible_program_infeasible(seed):
    rng = np.random.default_rng(seed)
    arms = random_arms(rng, 2, sides=[4, "exact"][seed % 2])
    program = build_allocation(cart(), arms, first_contacts(arms), (0, 0, 0))  # the zero wrench is feasible
    slack_map = np.eye(2)
    solution = QuadraticSolver(always_feasible=True).solve(projection_program(program, slack_map))
    for _ in range(50):
        y = rng.normal(size=len(solution.multipliers)) * rng.choice([0, 1], len(solution.multipliers))
        z = tuple(rng.normal(size=3) for _ in program.cones)
        wild = replace(solution, multipliers=y, cone_multipliers=z)
        assert infeasible_by(program, wild, np.ones(2)) <= 1e-9


@pytest.mark.parametrize("sides", [4, "exact"])
def test_the_multipliers_of_a_projection_prove_its_distance(sides):
    arms = [arm("left", friction=Friction(0.6, sides)), arm("right", [(-0.25, -0.2, 1.0)])]
    program = build_allocation(cart(), arms, first_contacts(arms), (150, 0, 40))
    projection = project(QuadraticSolver(always_feasible=True), program, np.eye(2))
    proven = infeasible_by(program, projection.normal_solution, projection.normal)
    assert proven == pytest.approx(projection.distance, rel=1e-9)


def test_the_fallback_is_reported(monkeypatch):
    arms = [arm()]
    program = build_allocation(cart(), arms, first_contacts(arms), (40, 0, 3))
    solver = QuadraticSolver()
    failed = replace(solver.solve(program), status="numerical", message="daqp gave up (flag -2)")
    failed = replace(failed, residuals=failed.residuals._replace(equality=np.inf))
    monkeypatch.setattr(solver._first, "solve", lambda _: failed)
    solution = solver.solve(program)
    assert solution.status == "optimal"
    assert solution.solver.startswith("clarabel")
    assert "flag -2" in solution.message
