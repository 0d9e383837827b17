"""The cost of switching: optimal against brute force, nothing where nothing moves, and hands that stay."""

from __future__ import annotations

import json
from itertools import combinations, product

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cartgrasp.errors import UsageError
from planning import Skid, TipOver, WrenchPlanner, allocate
from planning.contacts.contact_regions import hand_distance

from ..drawn import arm, bar, cart, random_arms, random_cart, violation
from .test_contact_choice_with_cart_limits import shopping_cart

HANDLE = [(-0.25, y, 1.0) for y in np.linspace(-0.25, 0.25, 21)]


def warm(model, arms, **options):
    planner = WrenchPlanner(model, arms, **options)
    planner.warm_up()
    return planner


def plain(model, arms, **options):
    return WrenchPlanner(model, arms, **options)


def value(plan):
    return plan.effort + plan.choice.switching


def paid(plan, held, costs):
    """Written down anew: who isn't where it was pays."""
    return sum(costs[name] for name, point in plan.contacts.items() if tuple(point) != tuple(held[name]))


def by_subsets(model, arms, wrench, held, costs, **options):
    """The optimum by another road: for each set of arms that move, the best with the others fixed, which a planner
    without a cost of switching proves; and the largest of its gaps."""
    best, gap = np.inf, 0.0
    for n_moving in range(len(arms) + 1):
        for moving in combinations(held, n_moving):
            stay = {name: point for name, point in held.items() if name not in moving}
            plan = WrenchPlanner(model, arms, **options).plan(wrench, contacts=stay)
            if plan.status == "optimal":
                best = min(best, plan.effort + sum(costs[name] for name in moving))
                gap = max(gap, plan.choice.gap)
    return best, gap


# --- optimal ------------------------------------------------------------------------------------------------

seeds = st.integers(0, 2**32 - 1)
cost = st.floats(0.0, 3e3)


@pytest.mark.long
@settings(max_examples=30, deadline=None)
@given(seeds, cost, cost, st.sampled_from([plain, warm]), st.sampled_from([0.0, 0.4]))
def test_over_points_it_is_the_least_of_all_choices(seed, one, other, make, distance):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 4))
    model, arms = random_cart(rng), random_arms(rng, n, n_points=(0, 12, 6, 3)[n])
    costs = dict(zip(("arm0", "arm1", "arm2"), (one, other, 50.0), strict=True))
    costs = {a.name: costs[a.name] for a in arms}
    planner = make(model, arms, min_hand_distance=distance, switching_cost=costs)
    held = {a.name: a.contacts.points[rng.integers(len(a.contacts.points))] for a in arms}
    planner.start_from({}, held)
    wrench = rng.uniform((0, -10, -12), (80, 10, 12))
    plan, best = planner.plan(wrench), np.inf
    for points in product(*(a.contacts.points for a in arms)):
        contacts = {a.name: point for a, point in zip(arms, points, strict=True)}
        found = allocate(model, arms, contacts, wrench)
        if found.status == "optimal" and hand_distance(np.array(points)) >= distance - 1e-12:
            best = min(best, found.effort + sum(costs[k] for k in contacts if contacts[k] != held[k]))
    assert plan.status == ("optimal" if np.isfinite(best) else "infeasible")
    if plan.status == "optimal":
        assert plan.choice.switching == pytest.approx(paid(plan, held, costs))
        assert value(plan) == pytest.approx(best, rel=2e-9, abs=1e-9)
        assert plan.choice.bound <= best * (1 + 1e-9) + 1e-9
        assert plan.choice.gap <= 1e-9
        moved = tuple(k for k in held if tuple(plan.contacts[k]) != held[k])
        assert plan.switched == (moved if any(costs.values()) else ())


@pytest.mark.long
@settings(max_examples=40, deadline=None)
@given(seeds, cost, cost, st.sampled_from([0.0, 0.25]))
def test_over_segments_it_is_the_least_of_all_subsets_that_move(seed, one, other, distance):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 3))
    ends = [
        np.array([(-0.25, -0.25, 1.0), (-0.25, 0.25, 1.0)]),
        rng.uniform((-0.4, -0.4, 0.9), (0.1, 0.4, 1.1), (2, 3)),
    ]
    arms = [arm(f"arm{i}", (), segment=ends[i].tolist(), weights=rng.uniform(0.5, 12, 6)) for i in range(n)]
    costs = {a.name: c for a, c in zip(arms, (one, other), strict=False)}
    shares = rng.uniform(0, 1, n) * rng.integers(0, 2, n)  # ends as well
    held = {a.name: tuple(a.contacts.segments[0].at(s)) for a, s in zip(arms, shares, strict=True)}
    assume(hand_distance(np.array(list(held.values()))) >= distance)
    planner = WrenchPlanner(cart(), arms, min_hand_distance=distance, switching_cost=costs)
    planner.start_from({}, held)
    wrench = rng.uniform((5, 0, -12), (60, 0, 12))
    plan = planner.plan(wrench)
    best, _ = by_subsets(cart(), arms, wrench, held, costs, min_hand_distance=distance)
    assert plan.status == ("optimal" if np.isfinite(best) else "infeasible")
    if plan.status != "optimal":
        return
    assert value(plan) == pytest.approx(best, rel=3e-9, abs=1e-8)
    assert plan.choice.switching == pytest.approx(paid(plan, held, costs))
    assert plan.choice.gap <= 1e-9
    assert violation(arms, plan.wrenches) <= 1e-8
    scans = [[held[a.name], *(tuple(a.contacts.segments[0].at(s)) for s in np.linspace(0, 1, 9))] for a in arms]
    for points in product(*scans):
        contacts = {a.name: point for a, point in zip(arms, points, strict=True)}
        found = allocate(cart(), arms, contacts, wrench)
        if found.status == "optimal" and hand_distance(np.array(points)) >= distance:
            of_grid = found.effort + sum(costs[k] for k in contacts if contacts[k] != held[k])
            assert plan.choice.bound <= of_grid * (1 + 1e-9) + 1e-9


@pytest.mark.parametrize("held_at", [-0.2, 0.1])
@pytest.mark.parametrize("segment", [False, True])
def test_with_limits_of_the_cart(segment, held_at):
    """Over segments these are widened: both roads say how far from the best they may be."""
    make = bar if segment else lambda name, **more: arm(name, HANDLE[::4], **more)
    arms = [make("left", friction=None), make("right", friction=None)]
    limits = {"cart_limits": [Skid(0.5), TipOver(5.0)], "min_hand_distance": 0.2}
    held = {"left": (-0.25, held_at, 1.0), "right": (-0.25, held_at + 0.1 * (-1 if held_at > 0 else 3), 1.0)}
    if not segment:
        held = {name: min(HANDLE[::4], key=lambda p, y=point[1]: abs(p[1] - y)) for name, point in held.items()}
    for wrench in ((-90, 0, 6), (60, 0, -9)):
        costs = {"left": 40.0, "right": 150.0}
        planner = WrenchPlanner(shopping_cart(), arms, switching_cost=costs, **limits)
        planner.start_from({}, held)
        plan = planner.plan(wrench)
        best, gap = by_subsets(shopping_cart(), arms, wrench, held, costs, **limits)
        assert plan.status == "optimal"
        assert plan.choice.gap <= (1e-3 if segment else 1e-9)
        assert plan.choice.bound <= best * (1 + 1e-9)
        assert value(plan) >= best * (1 - gap - 1e-9)


# --- hands that stay ----------------------------------------------------------------------------------------


def turning(n):
    return [(40.0, 0.0, 7.0 * np.sin(angle)) for angle in np.linspace(0.0, 2 * np.pi, n)]


@pytest.mark.long
def test_a_slowly_turning_wrench_moves_hands_seldom():
    """And at every tick the choice is the best for its cost and for what is held."""
    arms, costs = [arm("left", HANDLE), arm("right", HANDLE[:3])], {"left": 60.0, "right": 30.0}
    free, slow = (warm(cart(), arms, switching_cost=c) for c in (0.0, costs))
    moves, last, held = 0, None, None
    switched = []
    for wrench in turning(40):
        plan = free.plan(wrench)
        moves += sum(tuple(p) != tuple(last[k]) for k, p in plan.contacts.items()) if last else 0
        last = plan.contacts
        plan, best = slow.plan(wrench), np.inf
        for points in product(HANDLE, HANDLE[:3]):
            contacts = dict(zip(costs, points, strict=True))
            found = allocate(cart(), arms, contacts, wrench)
            of_moves = sum(costs[k] for k in contacts if held and contacts[k] != tuple(held[k]))
            best = min(best, found.effort + of_moves) if found.status == "optimal" else best
        assert value(plan) == pytest.approx(best, rel=1e-9)
        switched += plan.switched
        held = plan.contacts
    assert 0 < len(switched) < moves / 2


def test_on_a_handle_hands_do_not_creep():
    arms, moves = [bar("left"), bar("right")], {}
    for switching in (0.0, 40.0):
        planner, places = WrenchPlanner(cart(), arms, min_hand_distance=0.1, switching_cost=switching), []
        for wrench in turning(60):
            plan = planner.plan(wrench)
            assert plan.choice.gap <= 1e-9
            places.append(np.array(list(plan.contacts.values())))
        moves[switching] = int((np.abs(np.diff(places, axis=0)).max(axis=2) > 0).sum())
    assert 0 < moves[40.0] < moves[0.0] / 4


# --- what is held -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [plain, warm])
def test_nothing_is_charged_where_nothing_was_held(make):
    arms = [arm("left", HANDLE), arm("right", HANDLE)]
    planner, free = (make(cart(), arms, min_hand_distance=0.1, switching_cost=c) for c in (1e6, 0.0))
    for wrench in ((40, 0, 3), (50, 0, -9)):
        first, best = planner.plan(wrench), free.plan(wrench)
        assert first.effort == pytest.approx(best.effort, rel=1e-9)
        assert (first.choice.switching, first.switched) == (0.0, ())
        later = planner.plan((30, 0, 8))
        assert later.switched == ()
        assert {k: tuple(p) for k, p in later.contacts.items()} == {k: tuple(p) for k, p in first.contacts.items()}
        planner.reset()


@pytest.mark.parametrize("make", [plain, warm])
def test_contacts_that_are_given_cost_nothing_and_are_held_then(make):
    planner = make(cart(), [arm("left", HANDLE), arm("right", HANDLE)], switching_cost=1e6)
    planner.plan((40, 0, 3), {"left": HANDLE[2], "right": HANDLE[20]})
    given_both = planner.plan((40, 0, 3), {"left": HANDLE[4], "right": HANDLE[18]})
    assert given_both.choice.switching == 0.0
    assert given_both.switched == ("left", "right")
    given_one = planner.plan((40, 0, 3), {"left": HANDLE[6]})
    assert given_one.choice.switching == 0.0
    assert given_one.switched == ("left",)
    assert tuple(given_one.contacts["right"]) == HANDLE[18]
    free = planner.plan((40, 0, -3))
    assert [tuple(p) for p in free.contacts.values()] == [HANDLE[6], HANDLE[18]]
    assert planner.plan((np.nan, 0, 0)).switched == ()
    assert planner.plan_or_hold((400, 0, 0)).held.contacts["left"] == pytest.approx(HANDLE[6])
    assert planner.plan((40, 0, 3)).switched == ()


@pytest.mark.parametrize("make", [plain, warm])
def test_what_was_given_off_the_candidates_has_to_be_left(make):
    planner = make(cart(), [arm("left", HANDLE)], switching_cost=70.0)
    planner.plan((40, 0, 3), {"left": (-0.3, 0.01, 1.0)})
    plan = planner.plan((40, 0, 3))
    assert (plan.switched, plan.choice.switching) == (("left",), 70.0)
    assert plan.effort == pytest.approx(WrenchPlanner(cart(), [arm("left", HANDLE)]).plan((40, 0, 3)).effort)


@pytest.mark.parametrize("make", [plain, warm])
def test_hands_move_where_staying_is_infeasible(make):
    planner = make(cart(), [arm("left", HANDLE)], switching_cost=1e5)
    stayed, moved = planner.plan((40, 0, 9)), planner.plan((40, 0, -9))
    assert stayed.switched == ()
    assert moved.switched == ("left",)
    assert moved.choice.switching == 1e5
    assert moved.choice.bound == pytest.approx(moved.effort + 1e5)


@pytest.mark.parametrize("make", [plain, warm])
def test_arms_whose_candidates_change(make):
    planner = make(cart(), [arm("left", HANDLE), arm("right", HANDLE)], switching_cost=500.0)
    held = planner.plan((40, 0, 3)).contacts
    weak = arm("left", HANDLE, force_limit=(50, 60, 40))
    assert planner.plan((40, 0, 4), arms=[weak, arm("right", HANDLE)]).switched == ()
    left = [point for point in HANDLE if point != tuple(held["left"])]
    plan = planner.plan((40, 0, 4), arms=[arm("left", left), arm("right", HANDLE)])
    assert plan.switched[0] == "left"
    assert plan.choice.switching == 500.0 * len(plan.switched)
    plan = planner.plan((40, 0, 0), arms=[arm("left", HANDLE[:1]), arm("right", HANDLE[-1:])])
    assert (plan.switched, plan.choice.switching) == (("left", "right"), 0.0)  # nothing is left to choose


def test_a_place_on_a_handle_is_held_until_the_handle_ends():
    planner = WrenchPlanner(cart(), [bar("hand")], switching_cost=1e4)
    held = planner.plan((40, 0, 7)).contacts["hand"]
    assert (planner.plan((40, 0, 2)).contacts["hand"] == held).all()
    short = bar("hand", low=float(held[1]) + 0.02)
    plan = planner.plan((40, 0, 2), arms=[short])
    assert (plan.switched, plan.choice.switching) == (("hand",), 1e4)


@pytest.mark.parametrize("make", [plain, warm])
def test_the_nearest_wrench_is_sought_without_a_cost_but_not_elsewhere_for_nothing(make):
    arms = [arm("left", HANDLE), arm("right", HANDLE)]
    planner = make(cart(), arms, switching_cost=1e6, relax=np.inf)
    held = planner.plan((40, 0, 3)).contacts
    at_held = plain(cart(), arms, relax=np.inf).plan((150, 0, 3), contacts=held)
    plan = planner.plan((150, 0, 3))
    assert plan.status == "relaxed"
    assert plan.nearest.distance == pytest.approx(at_held.nearest.distance, rel=1e-9)
    assert plan.switched == ()
    far = planner.plan((150, 0, 60))
    fresh = make(cart(), arms, relax=np.inf).plan((150, 0, 60))
    assert far.nearest.distance == pytest.approx(fresh.nearest.distance, rel=1e-7)
    assert far.nearest.distance < 0.99 * plain(cart(), arms).plan((150, 0, 60), contacts=held).nearest.distance
    assert far.switched
    assert far.choice.switching == 0.0


def test_starting_from_contacts():
    planner = WrenchPlanner(cart(), [arm("left", HANDLE), arm("right", HANDLE)], switching_cost={"left": 1e6})
    planner.start_from({}, {"left": HANDLE[3]})
    plan = planner.plan((40, 0, 3))
    assert tuple(plan.contacts["left"]) == HANDLE[3]
    assert plan.switched == ()  # nothing is known of the right hand
    document = json.loads(json.dumps(plan.as_dict(), allow_nan=False))
    assert "switched" not in document
    planner.start_from({}, {"left": (-0.3, 0.0, 1.0)})
    document = planner.plan((40, 0, -3)).as_dict()
    assert "left" in document["switched"]
    assert document["choice"]["switching"] == 1e6
    for wrong in ({"left": (np.nan, 0, 0)}, {"middle": (0, 0, 0)}, {"left": (0, 0)}, {"left": (1e200, 0, 0)}):
        with pytest.raises(UsageError, match="start_from: contacts: "):
            planner.start_from({}, wrong)


@pytest.mark.parametrize("wrong", [-1.0, np.nan, np.inf, 1e300, {"left": -2.0}, {"middle": 1.0}])
def test_a_cost_that_is_none_is_refused(wrong):
    with pytest.raises(UsageError, match="switching_cost"):
        WrenchPlanner(cart(), [arm("left", HANDLE)], switching_cost=wrong)
