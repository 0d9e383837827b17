"""After `warm_up` a planner answers by compiled kernels: the same answers as before it, and the same refusals."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.arms import Arm, Friction
from planning import LoadShare, SearchLimit, Smoothness, WrenchPlanner, allocate
from planning.allocation.allocation_template import AllocationTemplate
from planning.allocation.duality import effort_cut
from planning.contacts.contact_bounds import Candidates
from planning.contacts.contact_regions import hand_distance
from planning.kernels import cut
from planning.kernels.cut import Table
from planning.kernels.proof import COST
from planning.quadratic_program import QPSolution
from planning.tick.compiled_allocation import SOLVER, CompiledAllocation
from planning.tick.compiled_choice import CompiledChoice
from tests.kernels_called import called

from ..drawn import arm, bar, cart, first_contacts, random_arms, random_cart, violation

COMPILED_CUT = called(cut.effort_cut)


def warm(model, arms, **options):
    planner = WrenchPlanner(model, arms, **options)
    planner.warm_up()
    return planner


def random_objective(rng, n):
    shares = rng.dirichlet(np.ones(n))
    names = [f"arm{i}" for i in range(n)]
    share = LoadShare(dict(zip(names, (shares / shares.sum()).tolist(), strict=True)), 3.0)
    return [None, None, Smoothness(2.0), share][int(rng.integers(4))]


@pytest.mark.some(20)
@pytest.mark.parametrize("seed", range(60))
def test_given_contacts_as_on_the_general_road(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 5))
    model, arms = random_cart(rng), random_arms(rng, n)
    objective = random_objective(rng, n)
    fast, slow = warm(model, arms, objective=objective), WrenchPlanner(model, arms, objective=objective)
    for _ in range(12):
        wrench = rng.uniform((-5, -20, -12), (90, 20, 12))
        contacts = {a.name: rng.uniform(-0.5, 0.5, 3) for a in arms} if rng.random() < 0.5 else None
        one, other = fast.plan(wrench, contacts), slow.plan(wrench, contacts)
        assert one.status == other.status
        if one.status == "optimal":
            assert one.solver == SOLVER
            assert one.residuals.proven
            assert one.effort == pytest.approx(other.effort, rel=1e-8, abs=1e-9)
            assert np.concatenate(list(one.wrenches.values())) == pytest.approx(
                np.concatenate(list(other.wrenches.values())), abs=1e-6
            )
            assert set(one.contacts) == set(other.contacts)
            assert one.choice.bound == pytest.approx(other.choice.bound, rel=1e-9, abs=1e-9)


def test_the_same_limits_are_named():
    for wrench in ((70, 0, 3), (100, 0, 0), (40, 0, 13)):
        arms = [arm("left"), arm("right", [(-0.25, -0.2, 1.0)])]
        one, other = (make(cart(), arms).plan(wrench) for make in (warm, WrenchPlanner))
        assert one.active == other.active
        assert one.as_dict().keys() == other.as_dict().keys()


def choices(arms, distance):
    for points in product(*(a.contacts.points for a in arms)):
        if hand_distance(np.array(points)) >= distance - 1e-12:
            yield {a.name: point for a, point in zip(arms, points, strict=True)}


def check_choice(seed, n_points=(0, 9, 5, 3), switching=0.0):
    """Against an allocation for each choice; `allocate` solves by daqp and Clarabel. `switching` is the most that an
    arm pays to move from the candidate that it holds."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    model, arms = random_cart(rng), random_arms(rng, n, n_points=n_points[n])
    wrench, distance = rng.uniform((0, -10, -12), (80, 10, 12)), float(rng.choice([0.0, 0.5]))
    costs = {a.name: float(rng.uniform(0, switching)) for a in arms}
    planner = warm(model, arms, min_hand_distance=distance, switching_cost=costs)
    held = {a.name: a.contacts.points[rng.integers(len(a.contacts.points))] for a in arms}
    planner.start_from({}, held)
    plan = planner.plan(wrench)

    def paid(contacts):
        return sum(costs[name] for name, point in contacts.items() if tuple(point) != held[name])

    found = [(allocate(model, arms, contacts, wrench), contacts) for contacts in choices(arms, distance)]
    best = min((one.effort + paid(contacts) for one, contacts in found if one.status == "optimal"), default=np.inf)
    assert plan.status == ("optimal" if np.isfinite(best) else "infeasible"), seed
    if plan.status == "optimal":
        assert plan.choice.switching == pytest.approx(paid(plan.contacts)), seed
        assert plan.effort + paid(plan.contacts) == pytest.approx(best, rel=2e-9, abs=1e-9), seed
        assert plan.choice.bound <= best * (1 + 1e-9) + 1e-9, seed
        assert plan.choice.gap <= 1e-9, seed
        assert plan.solver == SOLVER, seed
        assert violation(arms, plan.wrenches) <= 1e-8, seed
        assert hand_distance(np.array(list(plan.contacts.values()))) >= distance - 1e-9, seed
    return plan.status


@pytest.mark.long
@pytest.mark.parametrize("switching", [0.0, 200.0])
def test_choices_against_brute_force(switching):
    statuses = [check_choice(seed, switching=switching) for seed in range(60)]
    assert {"optimal", "infeasible"} <= set(statuses)


@pytest.mark.prove
@pytest.mark.parametrize("switching", [0.0, 200.0])
def test_choices_against_brute_force_10000_times(switching):
    statuses = [check_choice(seed, (0, 7, 4, 2), switching) for seed in range(1000, 11000)]
    assert min(statuses.count("optimal"), statuses.count("infeasible")) > 500


@pytest.mark.some(10)
@pytest.mark.parametrize("seed", range(20))
def test_choices_under_other_objectives(seed):
    rng = np.random.default_rng(seed)
    model, arms = cart(), random_arms(rng, 2, n_points=6)
    objective = [Smoothness(2.0), LoadShare({"arm0": 0.6, "arm1": 0.4}, 5.0)][seed % 2]
    fast, slow = warm(model, arms, objective=objective), WrenchPlanner(model, arms, objective=objective)
    for _ in range(3):
        wrench = rng.uniform((0, -10, -6), (50, 10, 6))
        one, other = fast.plan(wrench), slow.plan(wrench)
        assert one.status == other.status
        if one.status == "optimal":
            assert one.choice.bound == pytest.approx(other.choice.bound, rel=2e-9, abs=1e-9)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(20))
def test_a_cut_bounds_as_the_numpy_one(seed):
    """At all choices, and from the same solution; at the choice solved it is the cost."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    arms, objective = random_arms(rng, n, n_points=3), random_objective(rng, n)
    template = AllocationTemplate.of(random_cart(rng), arms, objective)
    cost = template.cost(rng.normal(size=6 * n))
    allocation = CompiledAllocation(template, cost)
    points = np.array([a.contacts.points[0] for a in arms])
    wrench = (6.0, 0.5, 0.3)
    if not allocation.solve(wrench, points):
        return
    search = CompiledChoice.of(Candidates.of([a.contacts for a in arms]), allocation)
    search._tables[2][:] = cost.weights
    workspace = allocation._workspace
    table = Table(*search._tables)
    constant = COMPILED_CUT(workspace, table)
    target, k = template.basis_b.T @ wrench, template.basis_b.shape[1]
    program = template.program(template.contact_rows(points), target, cost)
    solution = QPSolution.checked(program, workspace.claim.x, workspace.claim.y, (), SOLVER)
    cut = effort_cut(template, solution, workspace.claim.y[-k:], target, cost)
    for index, contacts in enumerate(product(*(a.contacts.points for a in arms))):
        picked = np.unravel_index(index, [3] * n)
        ours = constant + sum(table.phi[3 * i + int(j)] for i, j in enumerate(picked))
        assert ours == pytest.approx(float(cut.value(template.contact_rows(np.array(contacts)))), rel=1e-9, abs=1e-7)
    assert constant + table.phi[::3].sum() == pytest.approx(workspace.found[COST], rel=1e-9, abs=1e-7)


def test_what_is_not_covered_takes_the_general_road():
    cone = arm("left", friction=Friction(0.6, "exact"))
    flat = arm("left", weights=(0, 1, 1, 1, 1, 1))
    for arms in ([cone], [flat], [bar("left")]):
        plan = warm(cart(), arms).plan((20, 0, 1))
        assert plan.status == "optimal"
        assert plan.solver != SOLVER


def test_a_solver_that_fails_is_replaced_and_the_swap_is_told(monkeypatch):
    planner = warm(cart(), [arm()])
    monkeypatch.setattr(planner._now.compiled._allocation, "solve", lambda *_: False)
    plan = planner.plan((40, 0, 3))
    assert plan.status == "optimal"
    assert plan.solver.startswith("daqp")
    assert plan.message.startswith("fallback")


def test_bad_contacts_are_refused_and_leave_nothing_behind():
    planner = warm(cart(), [arm("left"), arm("right", [(-0.25, -0.2, 1.0)])])
    contacts = first_contacts([arm("left"), arm("right", [(-0.25, -0.2, 1.0)])])
    good = planner.plan((40, 0, 3), contacts)
    for bad in ((np.nan, 0, 0), (0, np.inf, 0), (1e7, 0, 0), (0, 0), "abc", None):
        for _ in range(2):
            plan = planner.plan((40, 0, 3), {**contacts, "left": bad})
            assert plan.status == "invalid_input"
            assert "left" in plan.message
    for bad in ({**contacts, "middle": (0, 0, 0)}, [(0, 0, 0)] * 2, 3):
        assert planner.plan((40, 0, 3), bad).status == "invalid_input"
    again = planner.plan((40, 0, 3), contacts)
    assert again.wrenches["left"] == pytest.approx(good.wrenches["left"], abs=1e-12)


anything = st.floats(allow_nan=True, allow_infinity=True)
triple = st.tuples(anything, anything, anything)


@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(triple, st.none() | triple), min_size=1, max_size=6))
def test_plan_or_hold_is_safe_whatever_comes(calls):
    arms = [arm("left"), arm("right", [(-0.25, -0.2, 1.0)])]
    planner = warm(cart(), arms)
    planner.plan_or_hold((40, 0, 3))
    for wrench, left in calls:
        contacts = None if left is None else {"left": left, "right": (-0.25, -0.2, 1.0)}
        given_back = planner.plan_or_hold(wrench, contacts).contact_wrenches
        assert np.isfinite(np.concatenate(list(given_back.wrenches.values()))).all()
        assert violation(arms, given_back.wrenches) <= 1e-6


def test_hands_keep_their_distance_at_given_contacts():
    planner = warm(cart(), [arm("left"), arm("right", [(-0.25, -0.2, 1.0)])], min_hand_distance=0.3)
    assert planner.plan((40, 0, 3)).status == "optimal"
    near = {"left": (-0.25, 0.1, 1.0), "right": (-0.25, -0.1, 1.0)}
    assert "0.3 m apart" in planner.plan((40, 0, 3), near).message
    assert planner.plan((40, 0, 3)).status == "optimal"


def test_contacts_that_change_in_place_are_seen():
    planner, point = warm(cart(), [arm("left")]), np.array([-0.25, 0.1, 1.0])
    first = planner.plan((20, 0, 0.5), {"left": point}).contacts["left"].copy()
    point[1] = -0.1
    second = planner.plan((20, 0, 0.5), {"left": point})
    assert first[1] == 0.1
    assert second.contacts["left"][1] == -0.1
    assert second.effort == pytest.approx(allocate(cart(), [arm("left")], {"left": point}, (20, 0, 0.5)).effort)


def many(n_points, n_arms=2):
    points = [(-0.25, y, 1.0) for y in np.linspace(-0.25, 0.25, n_points)]
    return [arm(f"arm{i}", points) for i in range(n_arms)]


def test_few_programs_are_solved():
    planner = warm(cart(), many(64), min_hand_distance=0.1)
    for wrench in ((40, 0, 3), (40, 0, 12), (90, 0, -20), (10, 0, 0)):
        planner.reset()
        assert planner.plan(wrench).choice.solved <= 20


def test_the_next_search_begins_where_the_last_ended():
    planner = warm(cart(), many(64), min_hand_distance=0.1)
    cold = planner.plan((40, 0, 3))
    again = planner.plan((40, 0, 3))
    assert again.contacts["arm0"] == pytest.approx(cold.contacts["arm0"])
    assert again.choice.solved <= cold.choice.solved


def test_a_search_that_is_cut_short_says_so():
    full = warm(cart(), many(40)).plan((40, 0, 3))
    for limit in (SearchLimit(2), SearchLimit(seconds=0.0)):
        short = warm(cart(), many(40), search_limit=limit).plan((40, 0, 3))
        assert short.status == "optimal"
        assert short.choice.bound <= full.effort <= short.effort * (1 + 1e-12)
    assert warm(cart(), many(40), search_limit=SearchLimit(2)).plan((40, 0, 3)).choice.gap > 1e-9
    assert full.choice.gap <= 1e-9


def test_a_search_that_is_cut_short_before_it_found_any_contacts_says_so():
    """By the clock as by the number of programs; no solver is to blame."""
    rng = np.random.default_rng(6)
    places = [[(x, y, 1.0) for x, y in rng.uniform(-0.5, 0.5, (12, 2))] for _ in range(2)]
    grip = {"friction": Friction(0.3), "push_only": True, "force_limit": (40.0,) * 3, "moment_limit": (0.5,) * 3}
    hands = [Arm(f"arm{i}", held, yaw=float(rng.uniform(-3, 3)), **grip) for i, held in enumerate(places)]
    wrench = (rng.normal(0, 30), 0, rng.normal(0, 20))
    for limit in (SearchLimit(16), SearchLimit(seconds=0.0)):
        plan = warm(cart(), hands, search_limit=limit).plan_or_hold(wrench)
        assert plan.status == "timeout"
        assert plan.message.startswith("no feasible contacts among the 16 programs solved")


def test_no_choice_keeps_the_distance():
    plan = warm(cart(), many(5), min_hand_distance=0.6).plan((40, 0, 0))
    assert plan.status == "infeasible"
    assert "0.6 m apart" in plan.certificate.words


def test_a_search_that_can_not_go_on_leaves_it_to_the_general_one(monkeypatch):
    planner = warm(cart(), many(6))
    monkeypatch.setattr(planner._now.compiled._allocation, "search", lambda *_: False)
    plan = planner.plan((40, 0, 3))
    assert plan.status == "optimal"
    assert plan.effort == pytest.approx(warm(cart(), many(6)).plan((40, 0, 3)).effort)
