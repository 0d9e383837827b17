"""Contact choice stays exact where limits depend on contacts or couple the arms: brute force, and dense scans."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.joint_torques import JointTorques
from planning import SearchLimit, WrenchPlanner
from planning.limits import InternalForce, Skid, TipOver

from ..drawn import arm, bar

WHEELS = (
    cg.Wheel("fixed", 0.0, 0.27),
    cg.Wheel("fixed", 0.0, -0.27),
    cg.Wheel("caster", 0.72, 0.2, 0.045),
    cg.Wheel("caster", 0.72, -0.2, 0.045),
)
NEAR = SearchLimit(solves=600, gap=2e-3)
LIMITS = [Skid(0.2), TipOver(15.0), InternalForce(1.0)]


def shopping_cart():
    inertia = cg.Inertia(24.0, (0.3, 0.02), 2.0)
    return cg.CartModel(inertia, cg.RollingConstraints(0.0), wheels=WHEELS, com_height=0.45)


def joints(rng):
    return JointTorques(0.5 * rng.normal(size=(6, 7)), rng.uniform(-5, 5, 7), rng.uniform(15, 60, 7))


def least(planner, arms, wrench, options, distance=0.0):
    """Least cost over all combinations of points that keep the distance, by an allocation for each."""
    best = np.inf
    for points in product(*options):
        if len(points) > 1 and np.linalg.norm(np.subtract(*points)) < distance - 1e-12:
            continue
        plan = planner.plan_or_hold(wrench, contacts={a.name: p for a, p in zip(arms, points, strict=True)})
        if plan.status == "optimal":
            best = min(best, plan.choice.bound)
    return best


def drawn(rng, n, size):
    arms = []
    for i in range(n):
        points = rng.uniform((-0.45, -0.5, 0.6), (-0.2, 0.5, 1.4), (size, 3)).tolist()
        arms.append(arm(f"arm{i}", points, friction=None, yaw=rng.uniform(-0.5, 0.5), joints=joints(rng)))
    return arms


def problem(seed):
    rng = np.random.default_rng(seed)
    n = 1 + seed % 2
    arms = drawn(rng, n, [0, 16, 6][n])
    return arms, rng.uniform((-70, 0, -25), (110, 0, 25)) * (1.0 if n == 2 else 0.6)


@pytest.mark.parametrize("seed", range(40))
def test_points_against_brute_force(seed):
    arms, wrench = problem(seed)
    planner = WrenchPlanner(shopping_cart(), arms, cart_limits=LIMITS)
    expected = least(planner, arms, wrench, [a.contacts.points for a in arms])
    planner.reset()
    plan = planner.plan(wrench)
    assert plan.status == ("optimal" if np.isfinite(expected) else "infeasible"), plan.message
    if plan.status == "optimal":
        assert plan.effort == pytest.approx(expected, rel=2e-9)
        assert plan.choice.gap <= 1e-9
        assert min(plan.margins.values()) >= -1e-8


def test_the_draws_above_meet_their_limits():
    """Else they would prove nothing: each limit of the cart, and a joint, is active in some of them."""
    met = set()
    for seed in range(40):
        arms, wrench = problem(seed)
        met |= set(WrenchPlanner(shopping_cart(), arms, cart_limits=LIMITS).plan_or_hold(wrench).active)
    words = " ".join(met)
    assert all(name in words for name in ("skid", "wheel", "internal force", "joint"))


@pytest.mark.some(12)
@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("distance", [0.0, 0.2])
def test_segments_against_a_dense_scan(seed, distance):
    rng = np.random.default_rng(seed)
    arms = [bar("left", friction=None, joints=joints(rng)), bar("right", friction=None, joints=joints(rng))]
    wrench = rng.uniform((-80, 0, -20), (90, 0, 20))
    planner = WrenchPlanner(shopping_cart(), arms, cart_limits=LIMITS, min_hand_distance=distance, search_limit=NEAR)
    scan = [(-0.25, y, 1.0) for y in np.linspace(-0.25, 0.25, 17)]
    expected = least(planner, arms, wrench, [scan, scan], distance)
    planner.reset()
    plan = planner.plan_or_hold(wrench)
    if np.isinf(expected):
        assert plan.status in ("optimal", "infeasible", "timeout")
        return
    assert plan.status == "optimal"
    assert plan.effort <= expected * (1 + 2e-3)
    assert plan.choice.bound <= expected * (1 + 1e-9)
    assert plan.choice.bound <= plan.effort * (1 + 1e-12)
    assert plan.choice.gap <= 2e-3
    assert min(plan.margins.values()) >= -1e-8


def test_on_a_rail_a_load_limit_still_depends_on_the_contact():
    """Lifting is cheap for one hand; where it holds decides which wheel it takes the load from."""
    cart = cg.CartModel(
        cg.Inertia(24.0, (0.3, 0.0), 2.0), cg.RollingConstraints(0.0, no_rotation=True), wheels=WHEELS, com_height=0.45
    )
    hand = bar("hand", friction=None)
    planner = WrenchPlanner(cart, [hand], cart_limits=[TipOver(55.0)], search_limit=NEAR)
    plan = planner.plan((45.0, 0.0, 0.0))
    scan = [[(-0.25, y, 1.0) for y in np.linspace(-0.25, 0.25, 101)]]
    expected = least(planner, [hand], (45.0, 0.0, 0.0), scan)
    assert plan.status == "optimal"
    assert plan.choice.bound <= expected
    assert plan.effort <= expected * (1 + 2e-3)
    assert any("wheel" in name for name in plan.active)
