"""Limits sit a second exam, in plans: where one bites it is active by its name, with a margin of zero, at a cost;
inside it is idle. Plans agree with cvxpy on the same problem, which here is written down from the limit's formula."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import cvxpy
import numpy as np
import pytest
from scipy.optimize import linprog

import cartgrasp as cg
from cartgrasp.contacts import grasp_map_planar, grasp_map_spatial
from cartgrasp.effects import PayloadChange
from cartgrasp.floor_reaction import FloorReaction
from cartgrasp.joint_torques import JointTorques
from cartgrasp.motion import Motion
from planning import WrenchPlanner, allocate
from planning import limits as all_limits
from planning.limits import CartLimit, FloorLimit, InternalForce, Pull, SideForce, Skid, TipOver

from ..contacts.test_contact_choice_with_cart_limits import WHEELS

MASS, COM, INERTIA, HEIGHT = 24.0, (0.3, 0.02), 2.0, 0.45
LEFT, RIGHT = np.array([-0.25, 0.2, 1.0]), np.array([-0.25, -0.2, 1.0])
LEVERS = np.array(
    [[0.1, 0.3, 0.2], [0.6, 0.5, 0.2], [0.2, -0.4, 0.1], [0.0, 0.1, 0.0], [0.0, 1.0, 0.8], [1.0, 0.0, 0.1]]
)
JOINTS = JointTorques(LEVERS, [2.0, -3.0, 0.5], [5.0, 9.0, 30.0])


def shopping_cart():
    return cg.CartModel(cg.Inertia(MASS, COM, INERTIA), cg.RollingConstraints(0.0), wheels=WHEELS, com_height=HEIGHT)


def hands(left: dict[str, Any]):
    limits = {"force_limit": (90, 60, 40), "moment_limit": (8, 8, 6)}
    return [cg.Arm("left", [LEFT.tolist()], **(limits | left)), cg.Arm("right", [RIGHT.tolist()], **limits)]


@dataclass
class Exam:
    """A limit, a wrench at which it bites by these names, and one inside; `formula` says it again, of the arms'
    wrenches F[0] and F[1], as cvxpy constraints."""

    bites: tuple[float, float, float]
    idle: tuple[float, float, float]
    names: tuple[str, ...]
    formula: Any
    left: dict[str, Any] = field(default_factory=dict)
    cart_limits: tuple[Any, ...] = ()
    cart: Any = shopping_cart


def joint_torques(F):
    torque = LEVERS.T @ F[0] + np.array([2.0, -3.0, 0.5])
    return [cvxpy.abs(torque) <= np.array([5.0, 9.0, 30.0])]


def at_rest(F):
    """Loads and lateral force at rest: by the balance of forces and moments, of the cart as it starts to move."""
    spatial = grasp_map_spatial(LEFT) @ F[0] + grasp_map_spatial(RIGHT) @ F[1]
    (dx, dy), J = COM, INERTIA + MASS * (COM[0] ** 2 + COM[1] ** 2)
    reduced = np.linalg.inv([[MASS, -MASS * dy], [-MASS * dy, J]])
    du, dr = (row @ cvxpy.hstack([spatial[0], spatial[5]]) for row in reduced)
    ax, ay = du - dy * dr, dx * dr  # of the centre of mass
    total = MASS * 9.81 - spatial[2]
    along = MASS * 9.81 * dx + spatial[4] - HEIGHT * MASS * ax
    across = MASS * 9.81 * dy - spatial[3] - HEIGHT * MASS * ay
    x, y = np.array([[w.x, w.y] for w in WHEELS]).T
    springs = np.vstack([np.ones(4), x, y])  # equal springs under a rigid cart give the least-norm loads
    loads = np.linalg.pinv(springs) @ cvxpy.hstack([total, along, across])
    return loads, MASS * dx * dr - spatial[1]


def tip_over(F):
    return [at_rest(F)[0] >= 20.0]


def skid(F):
    loads, lateral = at_rest(F)
    return [cvxpy.abs(lateral) <= 0.3 * (loads[0] + loads[1])]


def side_force(F):
    return [cvxpy.abs(at_rest(F)[1]) <= 8.0]


def soft_finger(F):
    """Two fingers of 25 N above and below the handle; the right hand as it is."""
    return [cvxpy.norm(cvxpy.hstack([F[0][0], F[0][1], F[0][5] / 0.03])) <= 2 * 0.6 * 25.0]


EXAMS = {
    "push only": Exam((-20, 0, 4), (40, 0, 1), ("left: push only",), lambda F: [F[0][0] >= 0], {"push_only": True}),
    "payload": Exam(
        (-120, 0, 0),
        (20, 0, 1),
        ("left: payload upper",),
        lambda F: [cvxpy.abs(F[0][2]) <= 4.905, *tip_over(F)],
        {"payload": 0.5},
        (TipOver(20.0),),
    ),
    "pull": Exam((-40, 0, 1), (20, 0, 1), ("left: pull upper",), lambda F: [F[0][0] >= -18], {"limits": [Pull(18.0)]}),
    "joint torque": Exam((110, 0, 2), (5, 0, 0.2), ("left: joint 0 torque upper",), joint_torques, {"joints": JOINTS}),
    "internal force": Exam(
        (60, 0, 8),
        (40, 0, 0.5),
        ("internal force of left upper",),
        lambda F: [cvxpy.abs(F[0][1] - F[1][1]) <= 2 * 0.5],
        {"weights": (1, 9, 1, 10, 10, 10)},
        (InternalForce(0.5),),
    ),
    "tip over": Exam((-110, 0, 0), (40, 0, 3), ("wheel 2 load", "wheel 3 load"), tip_over, {}, (TipOver(20.0),)),
    "skid": Exam((40, 0, 26), (40, 0, 3), ("skid to the right",), skid, {}, (Skid(0.3),)),
    "side force": Exam((40, 0, 14), (40, 0, 1), ("side force to the left",), side_force, {}, (SideForce(8.0),)),
    "soft finger": Exam(
        (60, 0, 6),
        (20, 0, 0.5),
        ("left: soft finger",),
        soft_finger,
        {"soft_finger": cg.SoftFinger(0.6, 0.03, 25.0, "z", "exact")},
    ),
}


def test_every_cart_limit_sits_it():
    kinds = {thing for thing in vars(all_limits).values() if isinstance(thing, type) and issubclass(thing, CartLimit)}
    examined = {type(one) for exam in EXAMS.values() for one in exam.cart_limits}
    assert kinds - {CartLimit, FloorLimit} == examined, "give each limit of the cart an exam, among EXAMS"
    assert kinds == {CartLimit, *_subclasses(CartLimit)}, "a limit is not in planning.limits"


def _subclasses(kind):
    """Those of the library, and theirs."""
    of_library = [one for one in kind.__subclasses__() if one.__module__.startswith("planning.")]
    return [found for one in of_library for found in (one, *_subclasses(one))]


def planner_of(exam, limited=True):
    known = {"weights": exam.left.get("weights", (1, 1, 1, 10, 10, 10))}
    left, limits = (exam.left, exam.cart_limits) if limited else (known, ())
    return WrenchPlanner(exam.cart(), hands(left), cart_limits=limits)


@pytest.mark.parametrize("name", EXAMS)
def test_it_bites_and_is_idle_inside(name):
    exam = EXAMS[name]
    plan, free = planner_of(exam).plan(exam.bites), planner_of(exam, limited=False).plan(exam.bites)
    assert plan.status == free.status == "optimal", plan.message
    assert set(exam.names) & set(plan.active)
    assert plan.effort > free.effort * (1 + 1e-6)
    for active in plan.active:
        assert plan.margins[active] == pytest.approx(0.0, abs=1e-8)
    assert min(plan.margins.values()) >= -1e-9
    inside, free = planner_of(exam).plan(exam.idle), planner_of(exam, limited=False).plan(exam.idle)
    assert inside.active == free.active == ()
    assert inside.effort == pytest.approx(free.effort, rel=1e-9)
    assert all(inside.margins[name] > 1e-3 for name in exam.names)


@pytest.mark.parametrize("name", EXAMS)
def test_the_formula_in_cvxpy_agrees(name):
    exam = EXAMS[name]
    for wrench in (exam.bites, exam.idle):
        plan = planner_of(exam).plan(wrench)
        F = [cvxpy.Variable(6), cvxpy.Variable(6)]
        cost = sum(
            cvxpy.sum_squares(cvxpy.multiply(np.sqrt(a.weights), f)) for a, f in zip(hands(exam.left), F, strict=True)
        )
        free = exam.cart().basis_b.T  # the rows in which the cart moves
        reached = free @ (grasp_map_planar(LEFT) @ F[0] + grasp_map_planar(RIGHT) @ F[1])
        box = np.array([90, 60, 40, 8, 8, 6.0])
        held = [reached == free @ np.array(wrench), *(cvxpy.abs(f) <= box for f in F), *exam.formula(F)]
        tight = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), 1e-10)
        best = cvxpy.Problem(cvxpy.Minimize(cost), held).solve(solver=cvxpy.CLARABEL, **tight)
        assert plan.effort == pytest.approx(best, rel=1e-6)


@pytest.mark.parametrize("seed", range(25))
@pytest.mark.parametrize("name", EXAMS)
def test_optimal_plans_are_proven_and_others_certified(name, seed):
    exam, rng = EXAMS[name], np.random.default_rng(seed)
    wrench = rng.uniform((-150, 0, -40), (150, 0, 40))
    plan = planner_of(exam).plan_or_hold(wrench)
    if plan.status == "optimal":
        assert plan.residuals.proven
        assert min(plan.margins.values()) >= -1e-7
        return
    assert plan.status == "infeasible"
    assert plan.certificate.verified
    reached = planner_of(exam).plan_or_hold(plan.nearest.wrench * (1 - 1e-7))
    assert plan.nearest.solution.residuals.feasible
    assert reached.status in ("optimal", "infeasible")


@pytest.mark.parametrize("bounds", [(3.0, 5.0), (5.0, 3.0)])
def test_of_limits_with_one_name_the_least_margin_is_told(bounds):
    """A second one hid the first, though it was narrower."""
    given = WrenchPlanner(shopping_cart(), hands({}), cart_limits=[SideForce(bound) for bound in bounds])
    alone = WrenchPlanner(shopping_cart(), hands({}), cart_limits=[SideForce(3.0)])
    assert given.plan((40, 0, 1)).margins == pytest.approx(alone.plan((40, 0, 1)).margins)


def test_the_same_by_allocate():
    exam = EXAMS["tip over"]
    found = allocate(
        shopping_cart(), hands({}), {"left": LEFT, "right": RIGHT}, exam.bites, cart_limits=exam.cart_limits
    )
    assert found.effort == pytest.approx(planner_of(exam).plan(exam.bites).effort)
    assert set(found.active) == set(exam.names)


def test_a_bend_taken_too_fast_needs_the_hands_or_is_contradicted():
    """At 1.5 m/s and 1 rad/s the wheels must give m u r = 36 N of side force, more than friction 0.1 of 140 N."""
    motion = Motion(np.zeros(3), np.array([1.5, 1.0]))
    plan = planner_at(motion, force=(90, 60, 40)).plan((20, 0, 2), estimate=estimate_at(motion))
    assert plan.status == "optimal"
    assert plan.active == ("skid to the right",)
    assert sum(w[1] for w in plan.wrenches.values()) > 5  # the hands push it in
    weak = planner_at(motion, force=(90, 2, 2)).plan((20, 0, 2), estimate=estimate_at(motion))
    assert weak.status == "infeasible"
    assert "skid to the right" in weak.message
    assert weak.certificate.verified
    assert weak.nearest.wrench[2] < 1.9  # it could still be let run wider
    assert planner_at(motion, force=(90, 2, 2)).plan((20, 0, 2)).status == "optimal"  # at rest


def test_limits_that_no_wrench_keeps_are_a_contradiction():
    """As above, with hands too weak for anything, twice as fast."""
    motion = Motion(np.zeros(3), np.array([3.0, 2.0]))
    plan = planner_at(motion, force=(2, 2, 2)).plan_or_hold((1, 0, 0), estimate=estimate_at(motion))
    assert plan.status == "infeasible"
    assert plan.certificate.words.startswith("skid to the right by ")
    assert plan.certificate.verified
    assert plan.nearest is None
    least = solve_least_skid(motion)
    assert plan.certificate.asked == pytest.approx(least, rel=1e-6)
    assert all((w == 0).all() for w in plan.contact_wrenches.wrenches.values())


def solve_least_skid(motion):
    """By how much the hands must miss the limit, by HiGHS on the floor's reaction."""
    floor = FloorReaction.of(shopping_cart(), motion)
    row = floor.lateral_map - 0.1 * floor.load_map[:2].sum(axis=0)
    constant = floor.lateral_offset - 0.1 * floor.load_offset[:2].sum()
    matrix = np.hstack([row @ grasp_map_spatial(p) for p in (LEFT, RIGHT)])
    box = [(-most, most) for most in (2, 2, 2, 8, 8, 6)] * 2
    return linprog(matrix, bounds=box, method="highs").fun + constant


def planner_at(motion, force):
    arms = [
        cg.Arm(n, [p.tolist()], force_limit=force, moment_limit=(8, 8, 6))
        for n, p in (("left", LEFT), ("right", RIGHT))
    ]
    return WrenchPlanner(shopping_cart(), arms, cart_limits=[Skid(0.1)])


def estimate_at(motion, time=1.0):
    cart = shopping_cart()
    return cg.Estimate(time, motion, {}, "", cart, cart.parameters)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Skid(-1.0), "skid: friction"),
        (lambda: TipOver(np.nan), "tip-over: least_load"),
        (lambda: InternalForce(-1.0), "internal force: bound"),
        (lambda: SideForce(np.nan), "side force: bound"),
        (lambda: plain(SideForce(9.0)), "side force: cart has no fixed wheels"),
        (lambda: InternalForce(1.0, (0, 0, 0)), "internal force: axis"),
        (lambda: plain(Skid(0.5)), "skid: cart has no fixed wheels"),
        (lambda: plain(TipOver()), "wheels of cart stand in one line"),
        (lambda: plain(TipOver(), WHEELS), "wheels and com_height are needed"),
    ],
)
def test_what_is_refused(make, words):
    with pytest.raises(cg.UsageError, match=words):
        make()


def plain(limit, wheels=()):
    cart = cg.CartModel(cg.Inertia(24.0, (0.3, 0.0), 2.0), cg.RollingConstraints(None), wheels=wheels)
    return WrenchPlanner(cart, hands({}), cart_limits=[limit])


def test_a_side_force_needs_no_wheel_loads():
    cart = cg.CartModel(cg.Inertia(MASS, COM, INERTIA), cg.RollingConstraints(0.0))
    plan = WrenchPlanner(cart, hands({}), cart_limits=[SideForce(8.0)]).plan((40, 0, 14))
    assert plan.wheel_side_force == pytest.approx(8.0)
    assert plan.wheel_loads is None
    assert plan.effort == pytest.approx(planner_of(EXAMS["side force"]).plan((40, 0, 14)).effort)


@pytest.mark.parametrize("warm", [False, True])
def test_a_plan_tells_what_its_wheels_take(warm):
    """By the balance of forces and moments written down above, at rest; on the limits these are what limits allow."""
    made = WrenchPlanner(shopping_cart(), hands({}), cart_limits=[TipOver(20.0), SideForce(8.0)])
    if warm:
        made.warm_up()
    for wrench in ((40, 0, 14), (-110, 0, 0), (30, 5, -3)):
        plan = made.plan(wrench)
        loads, lateral = at_rest([cvxpy.Constant(plan.wrenches[name]) for name in ("left", "right")])
        assert plan.wheel_loads == pytest.approx(loads.value, rel=1e-9)
        assert plan.wheel_side_force == pytest.approx(float(lateral.value), abs=1e-9)
        assert plan.as_dict()["wheel_loads"] == plan.wheel_loads.tolist()
        assert sum(plan.wheel_loads) == pytest.approx(9.81 * MASS - sum(w[2] for w in plan.wrenches.values()))
    held = made.plan_or_hold((np.nan, 0, 0))  # decays
    loads, _ = at_rest([cvxpy.Constant(held.contact_wrenches.wrenches[name]) for name in ("left", "right")])
    assert held.wheel_loads == pytest.approx(loads.value, rel=1e-9)
    assert made.plan((4000, 0, 0)).wheel_loads is None


def test_a_contradiction_whatever_the_contacts():
    motion = Motion(np.zeros(3), np.array([3.0, 2.0]))
    points = [(-0.25, y, 1.0) for y in np.linspace(-0.25, 0.25, 5)]
    weak = {"force_limit": (2, 2, 2), "moment_limit": (8, 8, 6)}
    arms = [cg.Arm("left", points, **weak), cg.Arm("right", points, **weak)]
    planner = WrenchPlanner(shopping_cart(), arms, cart_limits=[Skid(0.1)])
    plan = planner.plan((1, 0, 0), estimate=estimate_at(motion))
    assert plan.status == "infeasible"
    assert plan.certificate.words.startswith("skid to the right by ")
    assert plan.certificate.verified


def test_margins_by_hand():
    arms = [
        cg.Arm("left", [LEFT.tolist()], force_limit=(60, 60, 40), friction=cg.Friction(0.6, "exact"), joints=JOINTS)
    ]
    plan = WrenchPlanner(shopping_cart(), arms).plan((40, 0, -9))
    f, margins = plan.wrenches["left"], plan.margins
    assert margins["left: friction cone"] == pytest.approx(0.6 * f[0] - np.hypot(f[1], f[2]), abs=1e-9)
    assert margins["left: fx upper"] == pytest.approx(60 - f[0])
    assert margins["left: joint 2 torque lower"] == pytest.approx(JOINTS.torques(f)[2] + 30.0)
    assert "left: tx upper" not in margins  # it has no limit
    assert WrenchPlanner(shopping_cart(), arms).plan((400, 0, 0)).margins == {}


@pytest.mark.parametrize(("time", "load"), [(4.0, 0.0), (6.0, 8.0)])
def test_wheels_bear_a_load_from_when_it_is_put_on(time, load):
    """By the estimate's time. In front of the casters it lifts the fixed wheels, whose least load then binds."""
    cart = shopping_cart().with_effect(PayloadChange(5.0, 8.0, 1.2, 0.0))
    planner = WrenchPlanner(cart, hands({}), cart_limits=[TipOver(20.0)])
    seen = cg.Estimate(time, Motion(np.zeros(3), np.zeros(2)), {}, "", cart, cart.parameters)
    plan = planner.plan((10.0, 0.0, 0.0), estimate=seen)
    assert plan.wheel_loads.sum() == pytest.approx((MASS + load) * 9.81 - plan.contact_wrenches.spatial_wrench_b[2])
    alike = shopping_cart().with_inertia(cg.Inertia.from_phi(cart.phi_at(time)))
    other = WrenchPlanner(alike, hands({}), cart_limits=[TipOver(20.0)]).plan((10.0, 0.0, 0.0))
    assert plan.effort == pytest.approx(other.effort)
    assert plan.wheel_loads == pytest.approx(other.wheel_loads, abs=1e-3)
