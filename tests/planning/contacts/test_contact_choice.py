"""Contact choice against brute force over points and dense scans of segments."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from cartgrasp.arms import Friction
from planning import LoadShare, SearchLimit, Smoothness, WrenchPlanner, allocate
from planning.contacts.contact_cases import Answer
from planning.contacts.contact_regions import Box, Region, hand_distance

from ..drawn import arm, bar, cart, is_feasible, random_arms, random_cart, violation


def brute_force(model, arms, wrench, options, distance=0.0, objective=None):
    """Least effort over all combinations of points, by an allocation for each."""
    planner = WrenchPlanner(model, arms, objective=objective)
    best = np.inf
    for points in product(*options):
        if hand_distance(np.array(points)) < distance - 1e-12:
            continue
        planner.reset()
        plan = planner.plan(wrench, contacts={a.name: p for a, p in zip(arms, points, strict=True)})
        if plan.status == "optimal":
            best = min(best, plan.choice.bound)
    return best


def check(arms, plan, model, wrench, distance=0.0):
    """A plan's own claims: it is feasible, and its contacts keep the distance."""
    assert violation(arms, plan.wrenches) <= 1e-8
    basis = model.constraints.basis_b
    assert basis.T @ plan.contact_wrenches.wrench_b == pytest.approx(basis.T @ np.asarray(wrench), abs=1e-8)
    assert hand_distance(np.array(list(plan.contacts.values()))) >= distance - 1e-9
    assert plan.choice.bound <= plan.effort * (1 + 1e-12) + 1e-12


@pytest.mark.long
@pytest.mark.some(15)
@pytest.mark.parametrize("seed", range(60))
def test_points_against_brute_force(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    model, arms = random_cart(rng), random_arms(rng, n, n_points=[0, 12, 6, 4][n])
    wrench, distance = rng.uniform((0, -10, -12), (80, 10, 12)), float(rng.choice([0.0, 0.5]))
    expected = brute_force(model, arms, wrench, [a.contacts.points for a in arms], distance)
    plan = WrenchPlanner(model, arms, min_hand_distance=distance).plan(wrench)
    assert plan.status == ("optimal" if np.isfinite(expected) else "infeasible")
    if plan.status == "optimal":
        assert plan.effort == pytest.approx(expected, rel=2e-9, abs=1e-9)
        assert plan.choice.gap <= 1e-9
        check(arms, plan, model, wrench, distance)


@pytest.mark.some(10)
@pytest.mark.parametrize("objective", [Smoothness(2.0), LoadShare({"arm0": 0.6, "arm1": 0.4}, 5.0)])
@pytest.mark.parametrize("seed", range(10))
def test_points_against_brute_force_for_other_objectives(seed, objective):
    rng = np.random.default_rng(seed)
    model, arms = cart(), random_arms(rng, 2, n_points=6)
    wrench = rng.uniform((0, -10, -6), (50, 10, 6))
    expected = brute_force(model, arms, wrench, [a.contacts.points for a in arms], objective=objective)
    plan = WrenchPlanner(model, arms, objective=objective).plan(wrench)
    assert plan.status == ("optimal" if np.isfinite(expected) else "infeasible")
    if plan.status == "optimal":
        assert plan.choice.bound == pytest.approx(expected, rel=2e-9, abs=1e-9)


def test_many_points_need_few_programs():
    ys = np.linspace(-0.25, 0.25, 64)
    points = [(-0.25, y, 1.0) for y in ys]
    planner = WrenchPlanner(cart(), [arm("left", points), arm("right", points)], min_hand_distance=0.2)
    for wrench in ((40, 0, 3), (40, 0, 12), (90, 0, -20), (10, 0, 0)):
        plan = planner.plan(wrench)
        assert plan.status == "optimal"
        assert plan.choice.gap <= 1e-9
        assert plan.choice.solved <= 40


def test_more_arms_than_one_table_holds():
    rng = np.random.default_rng(2)
    arms = random_arms(rng, 4, n_points=20, sides=4)
    plan = WrenchPlanner(cart(), arms).plan((60, 0, 3))
    assert plan.status == "optimal"
    assert plan.choice.gap <= 1e-9
    start = {a.name: a.contacts.points for a in arms}
    for _ in range(300):
        contacts = {name: points[rng.integers(20)] for name, points in start.items()}
        other = allocate(cart(), arms, contacts, (60, 0, 3))
        assert other.status == "infeasible" or other.effort >= plan.effort * (1 - 1e-9)


@pytest.mark.long
@pytest.mark.some(5)
@pytest.mark.parametrize("seed", range(40))
def test_a_segment_against_a_dense_scan(seed):
    rng = np.random.default_rng(seed)
    model = random_cart(rng)
    (base,) = random_arms(rng, 1)
    ends = rng.uniform((-0.5, -0.5, 0.8), (0.5, 0.5, 1.2), (2, 3))
    a = arm(
        "arm0",
        (),
        segment=ends.tolist(),
        yaw=base.yaw,
        friction=base.friction,
        force_limit=base.force_limit,
        moment_limit=base.moment_limit,
        weights=base.weights,
    )
    wrench = rng.uniform((0, -8, -8), (50, 8, 8))
    scan = [tuple(ends[0] + s * (ends[1] - ends[0])) for s in np.linspace(0, 1, 401)]
    expected = brute_force(model, [a], wrench, [scan])
    plan = WrenchPlanner(model, [a]).plan(wrench)
    if np.isinf(expected):
        if plan.status == "optimal":  # a narrow window between two points of the scan
            check([a], plan, model, wrench)
        return
    assert plan.status == "optimal"
    check([a], plan, model, wrench)
    assert plan.effort <= expected * (1 + 1e-9) + 1e-9
    assert plan.effort >= expected * (1 - 5e-3) - 1e-2  # the scan is that dense


@pytest.mark.long
@pytest.mark.some(16)
@pytest.mark.parametrize("seed", range(16))
@pytest.mark.parametrize("distance", [0.0, 0.3, 0.45])
def test_two_segments_against_a_dense_scan(seed, distance):
    """Parallel, crossing and skew handles; hands apart by a distance that often binds."""
    rng = np.random.default_rng(seed)
    kind = seed % 4
    ends = [np.array([(-0.25, -0.25, 1.0), (-0.25, 0.25, 1.0)])] * 2
    if kind == 1:
        ends = [ends[0], ends[0] + np.array([0.05, 0.0, 0.1])]
    elif kind == 2:
        ends = [ends[0], np.array([(-0.4, 0.0, 1.0), (0.1, 0.1, 1.0)])]
    elif kind == 3:
        ends = list(rng.uniform((-0.4, -0.4, 0.9), (0.1, 0.4, 1.1), (2, 2, 3)))
    arms = [
        arm(name, (), segment=e.tolist(), weights=rng.uniform(0.5, 12, 6))
        for name, e in zip(("left", "right"), ends, strict=True)
    ]
    wrench = rng.uniform((5, 0, -16), (60, 0, 16))
    scans = [[tuple(e[0] + s * (e[1] - e[0])) for s in np.linspace(0, 1, 26)] for e in ends]
    expected = brute_force(cart(), arms, wrench, scans, distance)
    plan = WrenchPlanner(cart(), arms, min_hand_distance=distance).plan(wrench)
    if np.isinf(expected):
        assert plan.status in ("optimal", "infeasible")
        return
    assert plan.status == "optimal"
    check(arms, plan, cart(), wrench, distance)
    assert plan.choice.gap <= 1e-9
    assert plan.choice.solved < 1000
    assert plan.effort <= expected * (1 + 1e-9)
    assert plan.effort >= expected * 0.9 - 1.0  # the scan is coarse; the bound above is the exact one


@pytest.mark.parametrize("seed", range(10))
def test_a_segment_beside_points_keeps_its_distance(seed):
    rng = np.random.default_rng(seed)
    points = [(-0.25, y, 1.0) for y in np.linspace(-0.2, 0.2, 5)]
    arms = [bar("left"), arm("right", points, weights=rng.uniform(0.5, 12, 6))]
    wrench = rng.uniform((10, 0, -14), (60, 0, 14))
    scan = [(-0.25, y, 1.0) for y in np.linspace(-0.25, 0.25, 201)]
    expected = brute_force(cart(), arms, wrench, [scan, points], 0.22)
    plan = WrenchPlanner(cart(), arms, min_hand_distance=0.22).plan(wrench)
    assert plan.status == "optimal"
    check(arms, plan, cart(), wrench, 0.22)
    assert expected * 0.98 <= plan.effort <= expected * (1 + 1e-9)


def test_an_arm_with_points_and_a_segment():
    """The point off the handle is right for a moment that the handle can't serve."""
    both = arm("left", [(-0.25, -0.6, 1.0)], segment=[(-0.25, -0.25, 1.0), (-0.25, 0.25, 1.0)])
    planner = WrenchPlanner(cart(), [both])
    assert planner.plan((40, 0, 24.0)).contacts["left"] == pytest.approx([-0.25, -0.6, 1.0])
    assert planner.plan((40, 0, 4.0)).contacts["left"] == pytest.approx([-0.25, -0.1, 1.0], abs=1e-4)


@pytest.mark.long
def test_three_hands_on_one_bar():
    """The hull is only the box here, so the search may end early: then with an honest gap."""
    arms = [bar(name) for name in ("a", "b", "c")]
    plan = WrenchPlanner(cart(), arms, min_hand_distance=0.15, search_limit=SearchLimit(600)).plan((60, 0, 12))
    assert plan.status == "optimal"
    check(arms, plan, cart(), (60, 0, 12), 0.15)
    ys = np.linspace(-0.25, 0.25, 11)
    scan = [(-0.25, y, 1.0) for y in ys]
    expected = brute_force(cart(), arms, (60, 0, 12), [scan] * 3, 0.15)
    assert plan.choice.bound <= expected
    assert plan.effort <= expected * (1 + 1e-3)


def test_a_search_that_is_cut_short_says_so():
    ys = np.linspace(-0.25, 0.25, 40)
    arms = [arm("left", [(-0.25, y, 1.0) for y in ys]), arm("right", [(-0.25, y, 1.0) for y in ys])]
    full = WrenchPlanner(cart(), arms).plan((40, 0, 3))
    short = WrenchPlanner(cart(), arms, search_limit=SearchLimit(3)).plan((40, 0, 3))
    assert short.status == "optimal"
    assert short.choice.gap > 1e-9
    assert short.choice.bound <= full.effort <= short.effort
    none = WrenchPlanner(cart(), arms, search_limit=SearchLimit(1)).plan((40, 0, 17))
    assert none.status in ("timeout", "optimal")
    late = WrenchPlanner(cart(), arms, search_limit=SearchLimit(seconds=0.0)).plan((400, 0, 3))
    assert late.status == "timeout"


def test_what_no_solver_could_answer_keeps_the_bound_down(monkeypatch):
    """The best point is never solved: it must not be called worse than what was."""
    planner = WrenchPlanner(cart(), [arm("left", [(-0.25, y, 1.0) for y in (-0.2, -0.075, 0.1)])])
    true = planner.plan((40, 0, 3)).effort
    answer = planner._now.cases.answer

    def give_up(question, high, low, hull=None):
        return Answer(np.inf, proven=False) if high[0, 1] == -0.075 else answer(question, high, low, hull)

    monkeypatch.setattr(planner._now.cases, "answer", give_up)
    planner.reset()
    plan = planner.plan((40, 0, 3))
    assert plan.status == "optimal"
    assert plan.choice.bound <= true < plan.effort
    assert plan.choice.gap > 1e-9


@pytest.mark.parametrize("moment", [40, -40])
@pytest.mark.parametrize("distance", [0.0, 0.3])
def test_infeasible_everywhere_gives_the_nearest_of_all(distance, moment):
    ys = np.linspace(-0.25, 0.25, 6)
    points = [(-0.25, y, 1.0) for y in ys]
    arms = [arm("left", points), arm("right", points)]
    wrench = (150, 0, moment)
    planner = WrenchPlanner(cart(), arms, min_hand_distance=distance)
    plan = planner.plan(wrench)
    assert plan.status == "infeasible"
    nearest = np.inf
    for one, other in product(points, points):
        if np.linalg.norm(np.subtract(one, other)) >= distance:
            found = allocate(cart(), arms, {"left": one, "right": other}, wrench)
            assert found.status == "infeasible"
            nearest = min(nearest, found.certificate.nearest.distance)
    assert plan.nearest.distance == pytest.approx(nearest, rel=1e-8)
    assert plan.certificate.verified
    assert "36 choices" in plan.certificate.words
    reached = planner.plan(plan.nearest.wrench * np.array([1 - 1e-7, 0, 1 - 1e-7]))
    assert reached.status == "optimal"


def test_infeasible_on_a_segment():
    plan = WrenchPlanner(cart(), [bar("left"), bar("right")]).plan((150, 0, 0))
    assert plan.status == "infeasible"
    assert plan.nearest.distance == pytest.approx(30, rel=1e-9)
    assert plan.certificate.most == pytest.approx(120)


def test_hands_that_can_not_be_far_enough_apart():
    planner = WrenchPlanner(cart(), [bar("left"), bar("right")], min_hand_distance=0.6)
    plan = planner.plan((40, 0, 0))
    assert plan.status == "infeasible"
    assert "0.6 m apart" in plan.certificate.words
    assert (plan.certificate.asked, plan.certificate.most) == pytest.approx((0.6, 0.5))
    assert plan.certificate.verified
    assert plan.nearest is None
    fixed = WrenchPlanner(cart(), [arm("left"), arm("right")], min_hand_distance=0.1).plan((40, 0, 0))
    assert fixed.status == "infeasible"
    # Three points within 0.3 m: each pair could be apart, all three can't.
    corners = [(0, 0, 1), (0.3, 0, 1)]
    three = WrenchPlanner(cart(), [arm(n, corners) for n in "abc"], min_hand_distance=0.2).plan((40, 0, 0))
    assert three.status == "infeasible"
    assert "0.2 m apart" in three.certificate.words


def test_a_force_free_contact_may_be_anywhere():
    """Only one arm is worth using; the other gives nothing, so its contact is free and keeps the distance."""
    arms = [
        bar("left", weights=(1e-3, 1, 1, 10, 10, 10)),
        bar("right", force_limit=(0, 0, 0), moment_limit=(0, 0, 0)),
    ]
    plan = WrenchPlanner(cart(), arms, min_hand_distance=0.4).plan((20, 0, 4.0))
    check(arms, plan, cart(), (20, 0, 4.0), 0.4)
    assert plan.contacts["left"][1] == pytest.approx(-0.2, abs=1e-4)


def test_on_a_rail_contacts_do_not_matter():
    plan = WrenchPlanner(cart(2), [bar("left"), bar("right")], min_hand_distance=0.3).plan((40, 0, 3))
    assert plan.effort == pytest.approx(800)
    assert plan.choice.solved <= 4


@pytest.mark.parametrize("seed", range(20))
def test_the_hull_of_a_box_holds_all_that_is_allowed(seed):
    """Sampled contacts of a box that keep the distance lie in the region's hull; vertices keep it too."""
    rng = np.random.default_rng(seed)
    low, high = rng.uniform(-0.4, 0.4, (2, 2, 3))
    box = Box(low, high)
    distance = float(rng.uniform(0.1, 0.6))
    s = rng.uniform(0, 1, (400, 2))
    s = s[hand_distance(box.at(s)) >= distance]
    region = Region.of(box, distance)
    if region is None:
        assert len(s) == 0
        return
    assert hand_distance(region.vertices).min() >= distance - 1e-9
    extremes = region.extremes()
    for direction in rng.normal(size=(60, 2)):
        along = region.s @ direction
        assert (int(along.argmax()), int(along.argmin())) in extremes
        if len(s):
            assert (s @ direction).max() <= along.max() + 1e-12


def test_exact_cones_choose_as_well():
    points = [(-0.25, y, 1.0) for y in np.linspace(-0.25, 0.25, 5)]
    arms = [arm(n, points, friction=Friction(0.6, "exact")) for n in ("left", "right")]
    expected = brute_force(cart(), arms, (40, 0, 9), [points] * 2)
    plan = WrenchPlanner(cart(), arms).plan((40, 0, 9))
    assert plan.effort == pytest.approx(expected, rel=1e-8)
    assert plan.choice.gap <= 1e-8


def test_the_oracle_of_these_tests_can_say_no():
    arms = [arm("left")]
    assert not is_feasible(cart(), arms, {"left": np.array([-0.25, 0.2, 1.0])}, (100, 0, 0))
