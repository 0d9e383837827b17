"""Margins in plans: where contacts are chosen, with other objectives and arms; brute force and Monte Carlo."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import cartgrasp as cg
from planning import (
    LeastInternalForce,
    Lexicographic,
    LoadShare,
    Nothing,
    SearchLimit,
    Smoothness,
    TipOver,
    WeightedWrench,
    WorstArm,
    WrenchPlanner,
)

from ..drawn import arm, bar
from .test_robust import BITES, LIMITS, breaks, cart, covariance, estimate, hands


@pytest.mark.parametrize("seed", range(8))
def test_points_against_brute_force(seed):
    rng = np.random.default_rng(seed)
    points = [rng.uniform((-0.45, -0.4, 0.6), (-0.2, 0.4, 1.4), (4, 3)).tolist() for _ in range(2)]
    arms = [arm(name, own, friction=None) for name, own in zip(("left", "right"), points, strict=True)]
    wrench = rng.uniform((-100, 0, -20), (100, 0, 20))
    planner = WrenchPlanner(cart(), arms, cart_limits=LIMITS, confidence=0.99)
    told, best = estimate(covariance()), np.inf
    for left, right in product(*points):
        plan = planner.plan_or_hold(wrench, contacts={"left": left, "right": right}, estimate=told)
        best = min(best, plan.effort if plan.status == "optimal" else np.inf)
    plan = planner.plan_or_hold(wrench)
    assert plan.status == ("optimal" if np.isfinite(best) else "infeasible"), plan.message
    if plan.status == "optimal":
        assert plan.effort == pytest.approx(best, rel=1e-8)
        assert plan.choice.gap <= 1e-8


@pytest.mark.long
@pytest.mark.parametrize("wrench", [(-75, 0, 0), (40, 0, 15), (-50, 0, -12)])
def test_segments_against_a_dense_scan(wrench):
    arms = [bar("left", friction=None), bar("right", friction=None)]
    near = SearchLimit(solves=400, gap=5e-3)
    planner = WrenchPlanner(cart(), arms, cart_limits=LIMITS, confidence=0.99, search_limit=near)
    told, best = estimate(covariance()), np.inf
    scan = [(-0.25, y, 1.0) for y in np.linspace(-0.25, 0.25, 6)]
    for left, right in product(scan, scan):
        plan = planner.plan_or_hold(wrench, contacts={"left": left, "right": right}, estimate=told)
        best = min(best, plan.effort if plan.status == "optimal" else np.inf)
    plan = planner.plan_or_hold(wrench)
    assert plan.status == "optimal", plan.message
    assert plan.choice.bound <= best * (1 + 1e-9)
    assert plan.effort <= best * (1 + 6e-3)
    assert min(plan.margins.values()) >= -1e-7


OBJECTIVES = (
    WeightedWrench(),
    WorstArm(1.0),
    LoadShare({"left": 0.7, "right": 0.3}),
    Smoothness(0.5),
    LeastInternalForce(2.0),
    Lexicographic(WorstArm(1.0), WeightedWrench()),
)


@pytest.mark.parametrize("objective", OBJECTIVES, ids=lambda o: type(o).__name__)
@pytest.mark.parametrize("name", BITES)
def test_whatever_the_objective(objective, name):
    """Proven, within the true share of broken limits, and never better than without margins."""
    wrench, motion = BITES[name]
    told = estimate(covariance(), motion)
    planner = WrenchPlanner(cart(), hands(), objective=objective, cart_limits=LIMITS, confidence=0.99)
    plain = WrenchPlanner(cart(), hands(), objective=objective, cart_limits=LIMITS).plan(wrench, estimate=told)
    plan = planner.plan(wrench, estimate=told)
    assert plan.status == "optimal"
    assert plan.residuals.proven
    assert plan.choice.bound >= plain.choice.bound * (1 - 1e-7)
    draws = np.random.default_rng(3).multivariate_normal(cart().parameters, covariance(), 4000, method="cholesky")
    assert breaks(plan, draws, motion).mean() <= 0.01 + 3 * (0.01 * 0.99 / 4000) ** 0.5


def test_other_arms_keep_the_margins():
    """Weaker hands than before, and a rate of change: what was believed of the cart still holds."""
    told, weaker = estimate(covariance()), hands(force_limit=(100, 40, 40), wrench_rate=(5e4,) * 6)
    planner = WrenchPlanner(cart(), hands(), cart_limits=LIMITS, confidence=0.99)
    planner.plan((40, 0, 17), estimate=told)
    fresh = WrenchPlanner(cart(), weaker, cart_limits=LIMITS, confidence=0.99)
    planner.reset()
    plan, expected = planner.plan((40, 0, 17), arms=weaker), fresh.plan((40, 0, 17), estimate=told)
    assert plan.status == expected.status == "optimal", plan.message
    assert plan.active == expected.active
    assert plan.effort == pytest.approx(expected.effort, rel=1e-8)


@pytest.mark.parametrize("seed", range(40))
def test_margins_with_a_cost_that_is_flat(seed):
    """The worst arm alone leaves much open: over cones Clarabel stalls at some of these, and steps end where it should.
    A worst share that is only weighed a lot, beside effort, is no smaller."""
    rng = np.random.default_rng(seed)
    drawn = [
        cg.Arm(
            name,
            [rng.uniform((-0.4, -0.4, 0.8), (-0.2, 0.4, 1.2)).tolist()],
            yaw=rng.uniform(-1, 1),
            force_limit=rng.uniform(10, 90, 3),
            moment_limit=rng.uniform(1, 9, 3),
        )
        for name in ("left", "middle", "right")
    ]
    told, wrench = estimate(covariance(rng.uniform(0.1, 1))), rng.uniform((-40, -10, -8), (70, 10, 8))
    plans = []
    for base in (Nothing(), WeightedWrench()):
        objective = WorstArm(1.0 if isinstance(base, Nothing) else 1e6, base)
        planner = WrenchPlanner(cart(), drawn, objective=objective, cart_limits=[TipOver(5.0)], confidence=0.99)
        plans.append(planner.plan_or_hold(wrench, estimate=told))
    flat, curved = plans
    assert flat.status == curved.status == "optimal", flat.message
    shares = [
        max(float(np.abs(plan.wrenches[a.name] / a.wrench_limit).max()) for a in drawn) for plan in (flat, curved)
    ]
    assert flat.choice.bound == pytest.approx(shares[0] ** 2, rel=1e-6, abs=1e-8)
    assert shares[0] <= shares[1] + 1e-6
