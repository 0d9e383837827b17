"""Any solver by its name: all agree with the compiled road and with closed forms, whatever they are worth alone."""

from __future__ import annotations

import json
import warnings

import cvxpy
import numpy as np
import pytest
import qpsolvers
from hypothesis import given, settings
from hypothesis import strategies as st

import cartgrasp as cg
from planning import LeastSideForce, Lexicographic, Nothing, Skid, Smoothness, TipOver, WeightedWrench, WorstArm
from planning import WrenchPlanner as Planner
from planning.solvers import named_solver
from planning.solvers.cvxpy_problem import takes_cones
from planning.tick.compiled_allocation import SOLVER

from ..drawn import arm, bar, cart, effective_matrix, first_contacts, largest_scale, random_arms, random_cart
from ..limits.test_limits_in_plans import hands, shopping_cart

INSTALLED = sorted(qpsolvers.available_solvers)
each = pytest.mark.parametrize("name", INSTALLED)
CONIC = [name for name in INSTALLED if takes_cones(name)]
EXACT = cg.Friction(0.6, "exact")


def drawn(seed):
    """A cart, arms with every mix of linear limits, and a wrench at a share of what they can do."""
    rng = np.random.default_rng(seed)
    model, arms = random_cart(rng), random_arms(rng, int(rng.integers(1, 5)))
    wrench = rng.uniform((-5, -20, -12), (80, 20, 12))
    largest = largest_scale(model, arms, first_contacts(arms), wrench)
    if largest <= 1e-3:
        return model, arms, 0.0 * wrench
    return model, arms, wrench * (rng.uniform(0.05, 0.999) * largest if np.isfinite(largest) else 1.0)


@each
@given(seed=st.integers(0, 10**6))
@settings(max_examples=40, deadline=None, derandomize=True)
def test_it_agrees_with_the_compiled_road(name, seed):
    model, arms, wrench = drawn(seed)
    compiled = Planner(model, arms)
    compiled.warm_up()
    plan, other = compiled.plan(wrench), Planner(model, arms, solver=name).plan(wrench)
    assert plan.status == other.status == "optimal"
    assert other.residuals.proven
    assert max(other.residuals.as_dict().values()) <= 1e-9 * max(1.0, other.effort)
    assert other.effort == pytest.approx(plan.effort, rel=1e-10, abs=1e-12)
    for hand, found in other.wrenches.items():
        assert found == pytest.approx(plan.wrenches[hand], abs=1e-9 * max(1.0, np.abs(wrench).max()))


@each
def test_it_needs_no_fallback(name):
    """Of 60 problems none is left to Clarabel: what each finds leads the polish to the active limits."""
    for seed in range(60):
        model, arms, wrench = drawn(seed)
        plan = Planner(model, arms, solver=name).plan(wrench)
        assert (plan.solver, plan.message) == (f"{name}, polished", ""), seed


@each
def test_it_is_the_weighted_pseudo_inverse_where_nothing_limits(name):
    """F = W⁻¹ Aᵀ (A W⁻¹ Aᵀ)⁻¹ b."""
    arms = [cg.Arm(a, [(-0.25, y, 1.0)], weights=(1, 2, 3, 9, 9, 9)) for a, y in (("left", 0.2), ("right", -0.2))]
    matrix, inverse = effective_matrix(cart(), arms, first_contacts(arms)), np.diag(1 / np.tile([1, 2, 3, 9, 9, 9], 2))
    expected = inverse @ matrix.T @ np.linalg.solve(matrix @ inverse @ matrix.T, [40.0, 3.0])
    plan = Planner(cart(), arms, solver=name).plan((40, 0, 3))
    assert np.concatenate(list(plan.wrenches.values())) == pytest.approx(expected, abs=1e-12)


@each
def test_what_can_not_be_given_has_the_same_certificate(name):
    for wrench in ((400, 0, 3), (40, 0, 60), (-1, 0, 0)):
        ours, theirs = (Planner(cart(), [arm("left"), arm("right")], solver=one).plan(wrench) for one in (None, name))
        assert ours.status == theirs.status == "infeasible"
        assert theirs.certificate.verified
        assert theirs.certificate.words == ours.certificate.words
        assert theirs.nearest.wrench == pytest.approx(ours.nearest.wrench, abs=1e-9)


@each
def test_contacts_are_chosen_as_well(name):
    """Among points and on a segment, with limits of the cart."""
    points = [(-0.25, y, 1.0) for y in (-0.2, 0.0, 0.25)]
    for arms in ([arm("left", points), arm("right", points)], [bar("left"), arm("right", points)]):
        made = [Planner(shopping_cart(), arms, cart_limits=[Skid(0.3), TipOver(5)], solver=one) for one in (None, name)]
        ours, theirs = (planner.plan((60, 0, 9)) for planner in made)
        assert theirs.status == "optimal"
        assert theirs.choice.bound == pytest.approx(ours.choice.bound, rel=2e-3)
        assert theirs.effort == pytest.approx(ours.effort, rel=2e-3)


@each
@pytest.mark.parametrize(
    "objective",
    [Smoothness(1.0), WorstArm(50.0), LeastSideForce(2.0), Lexicographic(WorstArm(1.0, Nothing()), WeightedWrench())],
)
def test_any_objective(name, objective):
    """Over ticks that look back; what is least by an order of two has a program of its own."""
    made = [Planner(cart(), hands({}), objective=objective, solver=one) for one in (None, name)]
    for wrench in ((40, 0, 3), (60, 0, -4), (20, 0, 1)):
        ours, theirs = (planner.plan(wrench) for planner in made)
        assert theirs.status == "optimal"
        assert theirs.residuals.proven
        assert theirs.effort == pytest.approx(ours.effort, rel=1e-6)


@each
def test_cones_go_through_cvxpy_or_are_left_to_clarabel_and_said_so(name):
    for wrench in ((40, 0, 3), (60, 0, 9), (20, 0, -7)):
        ours, theirs = (Planner(cart(), hands({"friction": EXACT}), solver=one).plan(wrench) for one in (None, name))
        assert ours.status == theirs.status == "optimal"
        assert theirs.effort == pytest.approx(ours.effort, rel=1e-10)
        if name in CONIC:
            assert (theirs.solver, theirs.message) == (f"{name}, polished", "")
        else:
            assert theirs.message == f"fallback: {name} takes no second-order cones"
            assert theirs.solver.startswith("clarabel")


@each
def test_it_is_used_when_warm_too(name):
    planner = Planner(cart(), [arm("left")], solver=name.upper())
    planner.warm_up()
    assert planner.plan((40, 0, 3)).solver == f"{name}, polished"
    held = planner.plan_or_hold((400, 0, 3))
    assert held.status == "infeasible"
    assert held.certificate.verified
    default = Planner(cart(), [arm("left")])
    default.warm_up()
    assert default.plan((40, 0, 3)).solver == SOLVER


class Spoiled:
    """What qpsolvers may come back with."""

    def __init__(self, x, z):
        self.x, self.y, self.z = x, np.zeros(2), z


@pytest.mark.parametrize(
    "answer",
    [
        lambda n, m: Spoiled(None, None),
        lambda n, m: Spoiled(np.full(n, np.nan), np.zeros(m)),
        lambda n, m: Spoiled(np.zeros(n), np.full(m, np.inf)),
        lambda n, m: Spoiled(np.full(n, 1e80), np.zeros(m)),
        lambda n, m: Spoiled(np.zeros(n + 1), np.zeros(m)),
        lambda n, m: Spoiled(np.ones(n), np.ones(m)),
        lambda n, m: 1 / 0,
    ],
)
def test_a_solver_that_lies_or_fails_is_not_believed(monkeypatch, answer):
    def solve_problem(problem, solver, **settings):
        warnings.warn("it tells more on stderr", stacklevel=1)
        return answer(len(problem.q), len(problem.h))

    expected = Planner(cart(), [arm("left")]).plan((40, 0, 3))
    planner = Planner(cart(), [arm("left")], solver="osqp")
    monkeypatch.setattr(named_solver.qpsolvers, "solve_problem", solve_problem)
    plan = planner.plan((40, 0, 3))
    assert plan.status == "optimal"
    assert plan.residuals.proven
    assert plan.effort == pytest.approx(expected.effort)
    assert plan.message.startswith("fallback: osqp") or plan.solver == "osqp, polished"
    assert planner.plan((400, 0, 3)).certificate.verified


@pytest.mark.parametrize("wrong", ["gurobi", "no such solver", "", 7, ("osqp",)])
def test_what_is_not_installed(wrong):
    assert wrong not in INSTALLED
    with pytest.raises(cg.UsageError) as caught:
        Planner(cart(), [arm("left")], solver=wrong)
    assert str(caught.value) == f"solver: {wrong!r} is unknown or not installed; there are {', '.join(INSTALLED)}"


# --- the problem of a tick in cvxpy -------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["CLARABEL", "SCS"])
@pytest.mark.parametrize("friction", [cg.Friction(0.6), EXACT, None])
def test_the_problem_of_a_tick_by_any_solver_of_cvxpy(name, friction):
    planner = Planner(shopping_cart(), hands({"friction": friction}), cart_limits=[Skid(0.3), TipOver(20.0)])
    for wrench in ((40, 0, 3), (40, 0, 20), (-60, 0, 2)) if friction is None else ((40, 0, 3), (40, 0, 20)):
        plan, problem = planner.plan(wrench), planner.problem()  # the wrench and contacts of the last call
        assert problem.is_dpp()
        assert problem.solve(solver=name) == pytest.approx(plan.effort, rel=1e-4)
        for hand in ("left", "right"):
            assert problem.var_dict[hand].value == pytest.approx(plan.wrenches[hand], abs=0.05)


def test_its_wrench_and_contacts_may_be_others():
    planner = Planner(shopping_cart(), hands({}))
    planner.plan((40, 0, 3))
    moved = {"left": (-0.25, 0.1, 1.0)}
    expected = planner.plan((50, 0, -2), contacts=moved).effort
    other = Planner(shopping_cart(), hands({}))
    problem = other.problem(contacts=moved)  # no call yet: nothing is asked
    assert problem.solve(solver="CLARABEL") == pytest.approx(0.0, abs=1e-6)
    problem.param_dict["wrench"].value = np.array([50.0, 0.0, -2.0])
    assert problem.solve(solver="CLARABEL") == pytest.approx(expected, rel=1e-6)
    assert other.problem((50, 0, -2), moved).solve(solver="CLARABEL") == pytest.approx(expected, rel=1e-6)
    for wrong, words in (((np.nan, 0, 0), "wrench"), ((1, 2), "wrench")):
        with pytest.raises(cg.UsageError, match=words):
            other.problem(wrong)
    with pytest.raises(cg.UsageError, match="there is no arm 'hand'"):
        other.problem((1, 0, 0), {"hand": (0, 0, 1)})


@pytest.mark.parametrize(
    "objective",
    [Smoothness(1.0, WorstArm(50.0)), LeastSideForce(2.0), Smoothness(2.0)],
    ids=lambda one: type(one).__name__,
)
def test_it_is_that_of_the_next_tick(objective):
    """Rates count from the last plan, and so does smoothness; the cost is the program's, not the effort alone."""
    rated = {"wrench_rate": (4000.0,) * 6, "joints": None}
    planner = Planner(shopping_cart(), hands(rated), objective=objective)
    planner.plan((5, 0, 0.5))
    problem = planner.problem((9, 0, 1))
    plan = planner.plan((9, 0, 1))
    assert problem.solve(solver="CLARABEL") == pytest.approx(plan.proof[1].cost, rel=1e-5)
    assert problem.var_dict["left"].value == pytest.approx(plan.wrenches["left"], abs=1e-3)


def test_a_constraint_is_known_by_its_label_and_can_be_left_out():
    """Without the skid limits the same wrench costs what a planner without them pays."""
    limited = Planner(shopping_cart(), hands({}), cart_limits=[Skid(0.3)])
    limited.plan((40, 0, 26))
    problem = limited.problem()
    labels = [constraint.label for constraint in problem.constraints]
    assert {"left: at most", "right: at least", "cart, rows: at most", "what is asked of the cart"} == set(labels) - {
        "left: at least",
        "right: at most",
    }
    kept = [constraint for constraint in problem.constraints if not constraint.label.startswith("cart")]
    free = cvxpy.Problem(problem.objective, kept).solve(solver="CLARABEL")
    assert free == pytest.approx(Planner(shopping_cart(), hands({})).plan((40, 0, 26)).effort, rel=1e-6)
    assert problem.solve(solver="CLARABEL") > 1.01 * free


def test_a_problem_file_names_a_solver(tmp_path):
    """As the planner does; one that is not installed is refused at its key."""
    from planning.problem.problem_file import read_problem

    document = {
        "cart": {"name": "cart", "mass": 24.0, "com": [0.3, 0.0], "inertia": 2.0},
        "wrench": [40.0, 0.0, 3.0],
        "arms": [{"name": "left", "contacts": [[-0.25, 0.2, 1.0]]}],
        "solver": "OSQP",
    }
    path = tmp_path / "problem.yaml"
    path.write_text(json.dumps(document))
    assert read_problem(path).plan().solver == "osqp, polished"
    path.write_text(json.dumps(document | {"solver": "gurobi"}))
    with pytest.raises(
        cg.FileError, match=r"problem\.yaml:.*: solver: 'gurobi' is unknown or not installed; there are"
    ):
        read_problem(path)
