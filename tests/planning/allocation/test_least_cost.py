"""What is known of a cost before any program is solved, and what a search that ends at once says with it."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp.joint_torques import JointTorques
from planning import (
    LeastInternalForce,
    LeastJointTorque,
    LeastSideForce,
    Lexicographic,
    LoadShare,
    Nothing,
    SearchLimit,
    Smoothness,
    WeightedWrench,
    WorstArm,
    WrenchPlanner,
)
from planning.allocation.allocation_template import AllocationTemplate
from planning.allocation.duality import least_cost

from ..drawn import arm, bar, cart

OBJECTIVES = [
    WeightedWrench(),
    Nothing(),
    Smoothness(0.5, WorstArm(5.0)),
    Smoothness(2.0, LeastJointTorque(0.4)),
    LeastInternalForce(3.0, (0.0, 1.0, 0.3)),
    LeastSideForce(3.0, Smoothness(0.5)),
    LeastJointTorque(0.3, Nothing()),
    LoadShare({"left": 0.7, "right": 0.3}, 3.0),
    Lexicographic(WorstArm(1.0, Nothing()), WeightedWrench()),
]
LEVERS, AT_REST = np.random.default_rng(5).normal(size=(6, 7)), np.array([3.0, -2.0, 0.5, 1.0, 2.0, -1.0, 0.2])
JOINTS = JointTorques(LEVERS, AT_REST, [300.0] * 7)


def pair(**changes):
    return [arm(name, joints=JOINTS, **changes) for name in ("left", "right")]


def bound_and_cost(objective, previous, **changes):
    arms = pair(**changes)
    template = AllocationTemplate.of(cart(), arms, objective)
    cost = template.cost(previous, 12.0)
    return least_cost(template, cost), cost


@pytest.mark.parametrize("objective", OBJECTIVES, ids=lambda one: type(one).__name__)
def test_it_is_below_every_cost_and_not_below_zero(objective):
    rng = np.random.default_rng(1)
    previous = rng.normal(0, 20, 12)
    least, cost = bound_and_cost(objective, previous)
    assert least >= -1e-9 * max(1.0, cost.constant)
    limits = np.tile([60, 60, 40, 8, 8, 6], 2)
    for F in rng.uniform(-1, 1, (200, 12)) * limits * rng.choice([1e-3, 0.1, 1.0], (200, 1)):
        x = np.append(F, np.zeros(len(cost.weights) - 12))  # a share of none is less than any
        coupled = 0.0 if cost.coupling is None else x @ cost.coupling @ x
        assert least <= cost.weights @ x**2 + cost.gradient @ x + coupled + cost.constant


@pytest.mark.parametrize("rate", [0.2, 1.0, 4.0])
def test_of_a_change(rate):
    """Least of w F² + rate w (F - p)² is w p² rate / (1 + rate), where no limit is in the way; more where one is."""
    previous, weights = np.tile([20.0, -10, 5, 1, 1, -1], 2), (3, 3, 3, 2, 2, 2)
    free, held = (
        bound_and_cost(Smoothness(rate), previous, weights=weights, force_limit=(force, 60, 40))[0]
        for force in (60.0, 1.0)
    )
    assert free == pytest.approx(2 * (3 * 525 + 2 * 3) * rate / (1 + rate), rel=1e-12)
    assert held > free * 1.01


@pytest.mark.parametrize("is_warm", [False, True])
@pytest.mark.parametrize("objective", OBJECTIVES, ids=lambda one: type(one).__name__)
def test_a_search_that_ends_at_once_has_a_bound(objective, is_warm):
    """Hands begin where they can't turn the cart; that it could be turned elsewhere is not found in one program."""
    near, wide = [(-0.25, 0.01 * k, 1.0) for k in range(3)], [(-0.25, 0.4, 1.0)]
    arms = [arm(name, near + wide, joints=JOINTS) for name in ("left", "right")]
    wrench = (20, 0, -18)
    best = WrenchPlanner(cart(), arms, objective=objective).plan(wrench)
    assert best.status == "optimal"
    planner = WrenchPlanner(cart(), arms, objective=objective, search_limit=SearchLimit(1))
    if is_warm:
        planner.warm_up()
    plan = planner.plan(wrench)
    assert plan.status == "timeout"
    assert plan.choice.gap == np.inf
    assert -1e-9 <= plan.choice.bound <= best.choice.bound * (1 + 1e-9) + 1e-12


def test_a_segment_too():
    planner = WrenchPlanner(cart(), [bar("left"), bar("right")], search_limit=SearchLimit(seconds=0.0))
    plan = planner.plan((400, 0, 3))
    assert plan.status == "timeout"
    assert plan.choice.bound == 0.0
    assert plan.choice.solved == 0
