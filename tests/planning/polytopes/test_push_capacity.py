"""How much of a push arms can give: against the planner on both sides of the answer, and by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from cartgrasp.arms import Arm, Friction
from cartgrasp.constraints import RollingConstraints
from cartgrasp.errors import UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.joint_torques import JointTorques
from cartgrasp.model import CartModel
from planning.planner import WrenchPlanner
from planning.polytopes.push_capacity import push_capacity
from planning.polytopes.wrench_polytope import WrenchPolytope

from ...core.drawn import vectors

CART = CartModel(Inertia(60.0, (0.4, 0.0), 6.0), RollingConstraints(0.0))
LIMITS = {"force_limit": (60.0, 50.0, 40.0), "moment_limit": (8.0, 7.0, 6.0)}
ELBOW = JointTorques(np.random.default_rng(5).uniform(-0.6, 0.6, (6, 7)), np.full(7, 3.0), np.full(7, 30.0))
ARMS = (
    Arm("left", [(-0.3, 0.2, 1.0)], **LIMITS, friction=Friction(0.5, 6), yaw=0.2, joints=ELBOW),
    Arm("right", [(-0.3, -0.2, 1.0)], **LIMITS),
)


@settings(max_examples=30, deadline=None)
@given(vectors(3, -50, 50).filter(lambda wrench: np.abs(CART.basis_b.T @ wrench).max() > 1.0))
def test_the_planner_can_just_give_it(wrench: np.ndarray):
    capacity = push_capacity(CART, ARMS, wrench)
    planner = WrenchPlanner(CART, ARMS)
    assert planner.plan((1 - 1e-5) * capacity.multiple * wrench).status == "optimal"
    assert planner.plan((1 + 1e-5) * capacity.multiple * wrench).status == "infeasible"


@settings(max_examples=30, deadline=None)
@given(vectors(3, -50, 50).filter(lambda wrench: np.abs(CART.basis_b.T @ wrench).max() > 1.0))
def test_its_wrenches_give_it_within_every_limit(wrench: np.ndarray):
    capacity = push_capacity(CART, ARMS, wrench)
    total = np.zeros(3)
    for arm in ARMS:
        given_a, (x, y, _) = capacity.wrenches[arm.name], arm.contacts.points[0]
        polytope = WrenchPolytope.of(arm)
        assert (polytope.rows @ given_a <= polytope.limits + 1e-6).all()
        force = np.array([[np.cos(arm.yaw), -np.sin(arm.yaw)], [np.sin(arm.yaw), np.cos(arm.yaw)]]) @ given_a[:2]
        total += (*force, x * force[1] - y * force[0] + given_a[5])
    np.testing.assert_allclose(CART.basis_b.T @ total, capacity.multiple * CART.basis_b.T @ wrench, atol=1e-6)


def test_one_joint_that_bears_half_the_push():
    """A shoulder 0.5 m below the contact, 20 N·m, 5 of them for its own weight: 30 N forward, of the 60 asked for."""
    jacobian = np.zeros((6, 1))
    jacobian[0] = 0.5
    joints = JointTorques(jacobian, [5.0], [20.0])
    bare = {"force_limit": (1e3, 0.0, 0.0), "moment_limit": (0.0, 0.0, 0.0), "joints": joints}
    left, right = Arm("left", [(0, 0.2, 1)], **bare), Arm("right", [(0, -0.2, 1)], **bare)
    middle = Arm("middle", [(0, 0, 1)], **bare)
    assert push_capacity(CART, [middle], (60, 0, 0)).multiple == pytest.approx(0.5)
    assert push_capacity(CART, [left, right], (60, 0, 0)).multiple == pytest.approx(1.0)
    assert push_capacity(CART, [left, right], (60, 77, 0)).multiple == pytest.approx(1.0), "wheels bear a side force"


@pytest.mark.parametrize("wrench", [(0, 0, 0), (0, 5, 0), (np.nan, 0, 0), (np.inf, 0, 0)])
def test_a_wrench_that_moves_nothing_is_refused(wrench):
    with pytest.raises(UsageError, match=r"is no finite wrench \(fx, fy, tau\) that moves"):
        push_capacity(CART, ARMS, wrench)


@pytest.mark.parametrize(("arms", "words"), [((), "none given"), (ARMS[:1] * 2, "stands twice"), (ARMS[0], "no list")])
def test_arms_that_are_none_are_refused(arms, words):
    with pytest.raises(UsageError, match=words):
        push_capacity(CART, arms, (60, 0, 0))


def test_arms_without_limits_are_refused():
    with pytest.raises(UsageError, match="nothing limits this push"):
        push_capacity(CART, [Arm("hand", [(0, 0, 1)])], (1, 0, 0))
