"""Every objective sits the same exam: it is what its formula says, convex, and does what it is for."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import cvxpy
import numpy as np
import pytest
from scipy.optimize import linprog

from cartgrasp.errors import UsageError
from cartgrasp.frames import rotation_planar
from cartgrasp.friction import Friction
from cartgrasp.inertia import Inertia
from cartgrasp.joint_torques import JointTorques
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Motion
from planning import LoadShare, Smoothness, WeightedWrench, WrenchPlanner, allocate
from planning.allocation.allocation_template import AllocationTemplate
from planning.allocation.second_stage import second_stage
from planning.objectives import LeastInternalForce, LeastJointTorque, LeastSideForce, Lexicographic, Nothing, WorstArm
from planning.quadratic_program import verify
from planning.solvers import QuadraticSolver
from planning.tick.compiled_allocation import SOLVER

from ..drawn import arm, cart, effective_matrix, first_contacts

LEVERS, GRAVITY_TORQUE = np.random.default_rng(5).normal(size=(6, 4)), np.array([3.0, -2.0, 0.5, 1.0])
ARMS = [
    arm("left", weights=(1, 2, 3, 4, 5, 6), yaw=0.4, joints=JointTorques(LEVERS, GRAVITY_TORQUE, [300.0] * 4)),
    arm("right", [(-0.25, -0.2, 1.0)], weights=(2, 2, 1, 9, 9, 9)),
]
WEIGHTS = np.array([1, 2, 3, 4, 5, 6, 2, 2, 1, 9, 9, 9.0])


def effort(f, _):
    return WEIGHTS @ f**2


def change(f, previous):
    return effort(f, previous) + 0.5 * WEIGHTS @ (f - previous) ** 2


def shared(f, previous):
    left, right = rotation_planar(0.4) @ f[:2], f[6:8]
    total = left + right
    return effort(f, previous) + 3 * (np.sum((left - 0.7 * total) ** 2) + np.sum((right - 0.3 * total) ** 2))


def torques(f, previous):
    return effort(f, previous) + 0.3 * np.sum((LEVERS.T @ f[:6] + GRAVITY_TORQUE) ** 2)


def pressed(f, previous):
    """Half the difference along y, twice squared: what presses the handle together."""
    left, right = (rotation_planar(0.4) @ f[:2])[1], f[7]
    return effort(f, previous) + 4.0 * 2 * (0.5 * (left - right)) ** 2


STRAIGHT = 7.0  # N, that the wheels take of hands without any force across them


def sideways(f, previous):
    """The hands' force along {b}'s y takes from it what it gives."""
    across = (rotation_planar(0.4) @ f[:2])[1] + f[7]
    return effort(f, previous) + 2.0 * (STRAIGHT - across) ** 2


def worst(f, previous):
    limits = np.concatenate([a.wrench_limit for a in ARMS])
    return effort(f, previous) + 900.0 * np.max(np.abs(f) / limits) ** 2


OBJECTIVES = [
    (LeastJointTorque(0.3), torques),
    (LeastInternalForce(4.0), pressed),
    (WorstArm(900.0), worst),
    (LeastSideForce(2.0), sideways),
    (Smoothness(0.5, LeastSideForce(2.0)), lambda f, p: sideways(f, p) + change(f, p) - effort(f, p)),
    (WorstArm(900.0, LeastSideForce(2.0)), lambda f, p: worst(f, p) + sideways(f, p) - effort(f, p)),
    (
        LeastSideForce(1.5, LeastSideForce(0.5, LeastInternalForce(4.0))),
        lambda f, p: sideways(f, p) + pressed(f, p) - effort(f, p),
    ),
    (WorstArm(900.0, Smoothness(0.5)), lambda f, p: worst(f, p) + change(f, p) - effort(f, p)),
    (Smoothness(0.5, WorstArm(900.0)), lambda f, p: worst(f, p) + change(f, p) - effort(f, p)),
    (
        LoadShare({"left": 0.7, "right": 0.3}, 3.0, WorstArm(900.0)),
        lambda f, p: worst(f, p) + shared(f, p) - effort(f, p),
    ),
    (WeightedWrench(), effort),
    (Smoothness(0.5), change),
    (LoadShare({"left": 0.7, "right": 0.3}, 3.0), shared),
    (
        Smoothness(0.5, LoadShare({"left": 0.7, "right": 0.3}, 3.0)),
        lambda f, p: shared(f, p) + change(f, p) - effort(f, p),
    ),
    (
        LoadShare({"left": 0.7, "right": 0.3}, 3.0, Smoothness(0.5)),
        lambda f, p: shared(f, p) + change(f, p) - effort(f, p),
    ),
]


@pytest.mark.parametrize(("objective", "formula"), OBJECTIVES)
def test_exam(objective, formula):
    rng = np.random.default_rng(3)
    previous, wrenches = rng.normal(size=12), rng.normal(size=(5, 12))
    template = AllocationTemplate.of(cart(), ARMS, objective)
    cost = template.cost(previous, STRAIGHT)
    n = len(cost.weights)
    coupling = np.zeros((n, n)) if cost.coupling is None else cost.coupling
    for f in wrenches:
        x = f if cost.epigraph is None else np.append(f, np.max(cost.epigraph.rows[:, :12] @ f))
        value = cost.weights @ x**2 + cost.gradient @ x + x @ coupling @ x + cost.constant
        assert value == pytest.approx(formula(f, previous), rel=1e-12)
    assert np.linalg.eigvalsh(coupling).min() >= -1e-12
    assert template.hessian == pytest.approx(2 * np.diag(cost.weights) + 2 * coupling)
    other = template.cost(previous + 1, STRAIGHT)
    assert objective.looks_back == (other.constant != cost.constant)
    assert other.weights == pytest.approx(cost.weights)


@pytest.mark.parametrize(("objective", "formula"), OBJECTIVES)
def test_a_plan_is_no_worse_than_its_neighbours(objective, formula):
    """Steps along the null space of the equality, by the formula and not by the program. Wheels take m dx r' of hands
    without side force, with r' = tau / J: STRAIGHT at this moment, of a load 0.3 m ahead."""
    planner = WrenchPlanner(cart(), ARMS, objective=objective)
    first = planner.plan((30, 0, 2))
    previous = np.concatenate(list(first.wrenches.values()))
    mass, ahead, inertia = 24.0, 0.3, 2.0 + 24.0 * 0.3**2
    plan = planner.plan((36, 0, STRAIGHT * inertia / (mass * ahead)))
    x = np.concatenate(list(plan.wrenches.values()))
    template = AllocationTemplate.of(cart(), ARMS)
    matrix = np.hstack(list(template.contact_rows(np.array([plan.contacts[a.name] for a in ARMS]))))
    null = np.linalg.svd(matrix)[2][len(matrix) :]
    for direction in null:
        for step in (1e-3, -1e-3):
            assert formula(x + step * direction, previous) > formula(x, previous)


def test_smoothness_slows_a_change():
    """A contact that moves from y = 0.1 to 0.3 moves the load; the more a change costs, the less of it."""
    moved = []
    for objective in (None, Smoothness(1.0), Smoothness(10.0)):
        planner = WrenchPlanner(cart(), ARMS, objective=objective)
        held = [{"left": (-0.25, y, 1), "right": (-0.25, -0.2, 1)} for y in (0.1, 0.3)]
        before, after = (planner.plan((30, 0, 3), contacts=contacts) for contacts in held)
        moved.append(np.linalg.norm(after.wrenches["left"] - before.wrenches["left"]))
    assert moved[0] > moved[1] > moved[2]


def test_wheels_are_spared_as_far_as_it_is_worth():
    """Of hands that give all of a moment by side force and torques alone, more by force the more lambda weighs."""
    taken, efforts = [], []
    for weight in (0.0, 1.0, 100.0):
        plan = WrenchPlanner(cart(), ARMS, objective=LeastSideForce(weight)).plan((30, 0, 4))
        taken.append(abs(plan.wheel_side_force))
        efforts.append(plan.effort)
    assert taken[0] > 1.5 * taken[1] > 15 * taken[2]
    assert efforts[0] < efforts[1] < efforts[2]
    free = WrenchPlanner(cart(), ARMS, objective=LeastSideForce(1.0, Nothing())).plan((30, 0, 4))
    assert free.wheel_side_force == pytest.approx(0.0, abs=1e-7)
    order = Lexicographic(LeastSideForce(1.0, Nothing()), WeightedWrench())
    both = WrenchPlanner(cart(), ARMS, objective=order).plan((30, 0, 4))
    assert both.wheel_side_force == pytest.approx(0.0, abs=1e-6)
    assert efforts[2] < both.effort < free.effort
    second = Lexicographic(LeastInternalForce(1.0, base=Nothing()), LeastSideForce())
    plan = WrenchPlanner(cart(), ARMS, objective=second).plan((30, 0, 4))
    again = allocate(cart(), ARMS, first_contacts(ARMS), (30, 0, 4), second)
    assert plan.effort == pytest.approx(again.effort, rel=1e-9)


def test_the_side_force_is_that_of_the_estimate_at_every_tick():
    """Compiled and not, by the same cost, at motions and masses that change."""
    rng, objective = np.random.default_rng(2), LeastSideForce(3.0)
    roads = [WrenchPlanner(cart(), ARMS, objective=objective) for _ in range(2)]
    roads[0].warm_up()
    for tick in range(20):
        model = CartModel(Inertia(float(rng.uniform(15, 60)), (0.3, 0.02), 2.0), cart().constraints)
        now = Estimate(float(tick), Motion(np.zeros(3), rng.uniform(-0.8, 0.8, 2)), {}, "", model, model.parameters)
        wrench = rng.uniform((5, -5, -3), (40, 5, 3))
        one, other = (planner.plan(wrench, estimate=now) for planner in roads)
        assert (one.status, one.solver) == (other.status, SOLVER)
        assert one.effort == pytest.approx(other.effort, rel=1e-9)
        for plan in (one, other):
            cost = plan.effort + 3.0 * plan.wheel_side_force**2
            assert plan.proof[1].cost == pytest.approx(cost, rel=1e-9)


def test_a_heavy_share_is_kept():
    arms = [arm("left", friction=None), arm("right", [(-0.25, -0.2, 1.0)], friction=None)]
    objective = LoadShare({"left": 0.8, "right": 0.2}, 1e6)
    found = allocate(cart(), arms, first_contacts(arms), (30, 0, 0), objective)
    assert found.wrenches["left"][0] == pytest.approx(24, abs=1e-2)
    assert found.wrenches["right"][0] == pytest.approx(6, abs=1e-2)


def test_what_is_refused():
    for shares in ({"left": 0.5, "right": 0.4}, {"left": -0.1, "right": 1.1}, {"left": np.nan}, {}):
        with pytest.raises(UsageError, match="load share"):
            LoadShare(shares)
    with pytest.raises(UsageError, match="rate"):
        Smoothness(-1.0)
    with pytest.raises(UsageError, match="left"):
        WrenchPlanner(cart(), ARMS, objective=LoadShare({"left": 1.0}))


def test_shares_stay_as_they_were_given():
    """They had been the caller's own mapping: a plan was by numbers that nobody had looked at."""
    mine = {"left": 0.7, "right": 0.3}
    objective = LoadShare(mine, weight=1e6)
    mine["left"] = 0.1
    assert WrenchPlanner(cart(), ARMS, objective=objective).plan((30, 0, 0)).status == "optimal"
    assert objective.shares == {"left": 0.7, "right": 0.3}


def test_the_least_worst_share_is_that_of_a_linear_program():
    """Alone, WorstArm is a minimax: HiGHS finds the same share by minimising t."""
    arms = [arm("left", force_limit=(30, 60, 40), friction=None), arm("right", [(-0.25, -0.2, 1.0)], friction=None)]
    for wrench in ((40, 0, 3), (60, 0, 2), (20, 0, 9)):
        found = allocate(cart(), arms, first_contacts(arms), wrench, WorstArm(1.0, Nothing()))
        limits = np.concatenate([a.wrench_limit for a in arms])
        share = np.max(np.abs(np.concatenate(list(found.wrenches.values()))) / limits)
        rows = np.vstack([np.diag(1 / limits), -np.diag(1 / limits)])
        equality = effective_matrix(cart(), arms, first_contacts(arms))
        oracle = linprog(
            np.append(np.zeros(12), 1.0),
            np.hstack([rows, -np.ones((24, 1))]),
            np.zeros(24),
            np.hstack([equality, np.zeros((2, 1))]),
            [wrench[0], wrench[2]],
            bounds=[(None, None)] * 12 + [(0, None)],
        )
        assert share == pytest.approx(oracle.fun, rel=1e-7)


@pytest.mark.parametrize("wrench", [(40, 0, 3), (60, 0, 2), (20, 0, 9)])
def test_an_order_of_two(wrench):
    """As good as the first alone by the first, and the least effort among those, by cvxpy with the share held."""
    arms = [arm("left", force_limit=(30, 60, 40), friction=None), arm("right", [(-0.25, -0.2, 1.0)], friction=None)]
    limits, weights = (np.concatenate([getattr(a, name) for a in arms]) for name in ("wrench_limit", "weights"))
    first, order = WorstArm(1.0, Nothing()), Lexicographic(WorstArm(1.0, Nothing()), WeightedWrench())
    alone = allocate(cart(), arms, first_contacts(arms), wrench, first)
    share = np.max(np.abs(np.concatenate(list(alone.wrenches.values()))) / limits)
    plan = WrenchPlanner(cart(), arms, objective=order).plan(wrench)
    both = np.concatenate(list(plan.wrenches.values()))
    assert np.max(np.abs(both) / limits) == pytest.approx(share, rel=1e-8)
    assert plan.effort <= alone.effort
    F = cvxpy.Variable(12)
    held = [effective_matrix(cart(), arms, first_contacts(arms)) @ F == np.array([wrench[0], wrench[2]])]
    held.append(cvxpy.abs(F) <= share * (1 + 1e-9) * limits)
    best = cvxpy.Problem(cvxpy.Minimize(weights @ cvxpy.square(F)), held).solve(solver=cvxpy.CLARABEL)
    assert plan.effort == pytest.approx(best, rel=1e-6)
    again = allocate(cart(), arms, first_contacts(arms), wrench, order)
    assert again.effort == pytest.approx(plan.effort, rel=1e-9)


def test_a_second_is_found_for_a_first_that_is_proven_and_for_no_other():
    """A share of 68 from no solver's optimum would let the second exceed any."""
    template = AllocationTemplate.of(cart(), ARMS, WorstArm(1.0, Nothing()))
    points = np.array([ARMS[0].contacts.first, ARMS[1].contacts.first])
    program = template.program(template.contact_rows(points), np.array([40.0, 3.0]), template.cost(np.zeros(12)))
    proven = QuadraticSolver().solve(program)
    unproven = replace(proven, status="numerical", x=np.append(proven.x[:-1], 68.0))
    cost = WeightedWrench().cost(ARMS, np.zeros(12))
    found = second_stage(QuadraticSolver(), program, proven, cost)[1]  # daqp calls it infeasible
    assert found.status == "optimal"
    assert effort(found.x[:-1], None) < 0.999 * effort(proven.x[:-1], None)
    assert np.abs(found.x[:-1] / np.tile([60, 60, 40, 8, 8, 6], 2)).max() == pytest.approx(proven.x[-1], rel=1e-8)
    assert second_stage(QuadraticSolver(), program, unproven, cost) == (program, unproven)


@pytest.mark.parametrize(("seed", "count"), [(91, 3), (2354, 4), (2713, 3)])
def test_a_second_is_found_among_cones_too(seed, count):
    """An interior point finds no interior between rows 2e-9 apart: the plan had been the first's alone, 4 % and
    more above the least effort, with nothing said."""
    rng = np.random.default_rng(seed)
    wrench = (rng.uniform(5, 70), 0, rng.uniform(-8, 8))
    places = [(-0.25, 0.2, 1.0), (-0.25, -0.2, 1.0), (0.9, 0.2, 1.0), (0.9, -0.2, 1.0)][:count]
    arms = [arm(f"arm{i}", [place], friction=Friction(0.6, "exact")) for i, place in enumerate(places)]
    limits, weights = (np.concatenate([getattr(a, name) for a in arms]) for name in ("wrench_limit", "weights"))
    first = WorstArm(1.0, Nothing())
    alone, plan = (
        WrenchPlanner(cart(), arms, objective=one).plan(wrench)
        for one in (first, Lexicographic(first, WeightedWrench()))
    )
    shares = [np.max(np.abs(np.concatenate(list(p.wrenches.values()))) / limits) for p in (alone, plan)]
    assert shares[1] == pytest.approx(shares[0], rel=3e-9)
    F = cvxpy.Variable(6 * count)
    held = [effective_matrix(cart(), arms, first_contacts(arms)) @ F == np.array([wrench[0], wrench[2]])]
    held += [cvxpy.abs(F) <= shares[0] * (1 + 1e-6) * limits]
    held += [cvxpy.norm(F[6 * i + 1 : 6 * i + 3]) <= 0.6 * F[6 * i] for i in range(count)]
    best = cvxpy.Problem(cvxpy.Minimize(weights @ cvxpy.square(F)), held).solve(solver=cvxpy.CLARABEL)
    assert plan.effort == pytest.approx(best, rel=1e-4)


def test_a_second_that_no_solver_finds_is_told():
    """Every solver's answer that doesn't verify is none, so here none gives one: a cost of NaN."""
    template = AllocationTemplate.of(cart(), ARMS, WorstArm(1.0, Nothing()))
    points = np.array([ARMS[0].contacts.first, ARMS[1].contacts.first])
    program = template.program(template.contact_rows(points), np.array([40.0, 3.0]), template.cost(np.zeros(12)))
    proven, cost = QuadraticSolver().solve(program), WeightedWrench().cost(ARMS, np.zeros(12))
    found = second_stage(QuadraticSolver(), program, proven, replace(cost, gradient=np.full(12, np.nan)))[1]
    assert found.x is proven.x
    assert found.message == "the second objective is left open: no solver gave an answer for it that verifies"


@pytest.mark.parametrize("limit", [1e-320, 1e-12])
def test_a_limit_of_nothing_has_no_share(limit):
    """1 / 1e-320 is infinite; a limit of zero has none either."""
    other = arm("right", [(-0.25, -0.2, 1.0)], friction=None)
    hands = [[arm("left", force_limit=(30, most, 40), friction=None), other] for most in (limit, 0.0)]
    plans = [WrenchPlanner(cart(), arms, objective=WorstArm(9.0)).plan((40, 0, 3)) for arms in hands]
    assert plans[0].effort == pytest.approx(plans[1].effort)


def test_a_large_wrench_gives_a_share_no_room():
    """Limits may be broken by 1e-9 of what is asked for, in N: of a wrench of 87 N, 6e-8 more of the worst share was
    taken for best by the first."""
    wrench = np.array([87.0, 3.0])
    template = AllocationTemplate.of(cart(), ARMS, WorstArm(1.0, Nothing()))
    points = np.array([ARMS[0].contacts.first, ARMS[1].contacts.first])
    program = template.program(template.contact_rows(points), wrench, template.cost(np.zeros(12)))
    proven = QuadraticSolver().solve(program)
    second, found = second_stage(QuadraticSolver(), program, proven, WeightedWrench().cost(ARMS, np.zeros(12)))
    assert found.x[-1] == pytest.approx(proven.x[-1], rel=3e-9)
    for change in (1e-8, -1e-8):
        moved = np.append(found.x[:-1], found.x[-1] + change)
        assert not verify(second, moved, found.multipliers).feasible


@pytest.mark.parametrize(
    "objective", [LeastJointTorque(0.3), LeastInternalForce(4.0), LeastSideForce(2.0), WorstArm(900.0)]
)
@pytest.mark.parametrize("seed", range(6))
def test_contact_choice_by_brute_force(objective, seed):
    rng = np.random.default_rng(seed)
    points = [rng.uniform((-0.4, -0.4, 0.9), (0.1, 0.4, 1.1), (6, 3)).tolist() for _ in range(2)]
    joints = JointTorques(LEVERS, GRAVITY_TORQUE, [300.0] * 4)
    arms = [arm(name, p, joints=joints) for name, p in zip(("left", "right"), points, strict=True)]
    wrench = rng.uniform((5, 0, -8), (70, 0, 8))
    plan = WrenchPlanner(cart(), arms, objective=objective).plan_or_hold(wrench)
    best = np.inf
    for one, other in product(*points):
        found = allocate(cart(), arms, {"left": one, "right": other}, wrench, objective)
        best = min(best, found.solution.cost) if found.status == "optimal" else best
    assert plan.status == ("optimal" if np.isfinite(best) else "infeasible")
    if plan.status == "optimal":
        assert plan.choice.bound == pytest.approx(best, rel=3e-9)
        assert plan.choice.gap <= 1e-8


def test_more_that_is_refused():
    with pytest.raises(UsageError, match="weight"):
        WorstArm(0.0)
    with pytest.raises(UsageError, match="weight"):
        LeastJointTorque(-1.0)
    with pytest.raises(UsageError, match="weight"):
        LeastInternalForce(np.nan)
    with pytest.raises(UsageError, match="weight"):
        LeastSideForce(-1.0)
    with pytest.raises(UsageError, match="no fixed wheels to spare"):
        WrenchPlanner(cart(0), [arm("left")], objective=Smoothness(1.0, LeastSideForce()))
    with pytest.raises(UsageError, match="axis"):
        LeastInternalForce(1.0, axis=(0.0, 0.0, 0.0))
    with pytest.raises(UsageError, match="states its joints"):
        WrenchPlanner(cart(), [arm("left")], objective=LeastJointTorque())
    free = arm("left", force_limit=[np.inf] * 3, moment_limit=[np.inf] * 3)
    with pytest.raises(UsageError, match="limit to share"):
        WrenchPlanner(cart(), [free], objective=WorstArm(1.0))
    with pytest.raises(UsageError, match="unknowns of its own"):
        WrenchPlanner(cart(), [arm("left")], objective=WorstArm(1.0, WorstArm(1.0)))
    with pytest.raises(UsageError, match="order of two"):
        Lexicographic(Lexicographic(Nothing(), Nothing()), Nothing())
