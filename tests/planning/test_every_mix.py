"""Carts, arms, limits and objectives in every mix, with odd wrenches and estimates: answers are safe and true."""

from __future__ import annotations

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.contacts import grasp_map_spatial
from cartgrasp.floor_reaction import FloorReaction
from cartgrasp.motion import Motion
from planning import (
    InternalForce,
    LeastInternalForce,
    LeastSideForce,
    Lexicographic,
    Nothing,
    SearchLimit,
    SideForce,
    Skid,
    Smoothness,
    TipOver,
    WeightedWrench,
    WorstArm,
    WrenchPlanner,
)

from .contacts.test_contact_choice_with_cart_limits import WHEELS, joints

PERIOD = 0.01
STATUSES = {"optimal", "relaxed", "infeasible", "invalid_input", "stale_estimate", "timeout", "numerical"}
OBJECTIVES = [
    None,
    Smoothness(1.0),
    WorstArm(10.0),
    LeastInternalForce(1.0),
    LeastSideForce(2.0),
    Lexicographic(WorstArm(1.0, Nothing()), WeightedWrench()),
]


def drawn_cart(rng):
    rows = int(rng.choice([0, 1, 1, 2]))
    com = (float(rng.uniform(0.1, 0.6)), float(rng.uniform(-0.15, 0.15)))
    constraints = cg.RollingConstraints(float(rng.uniform(-0.3, 0.3)) if rows else None, no_rotation=rows == 2)
    wheels = WHEELS if rows else tuple(cg.Wheel("caster", w.x, w.y, 0.04) for w in WHEELS)
    inertia = cg.Inertia(float(rng.uniform(10, 80)), com, 2.0)
    return cg.CartModel(inertia, constraints, wheels=wheels, com_height=float(rng.uniform(0.2, 0.8)))


def drawn_arm(rng, name):
    points = rng.uniform((-0.4, -0.4, 0.8), (-0.2, 0.4, 1.2), (int(rng.integers(1, 4)), 3)).tolist()
    return cg.Arm(
        name,
        points,
        yaw=float(rng.uniform(-1, 1)),
        force_limit=rng.uniform(1, 90, 3),
        moment_limit=rng.uniform(0, 9, 3),
        friction=None if rng.random() < 0.5 else cg.Friction(float(rng.uniform(0.1, 1.0)), int(rng.choice([3, 4, 8]))),
        push_only=bool(rng.random() < 0.2),
        payload=float(rng.choice([np.inf, 3.0, 0.0])),
        wrench_rate=rng.choice([np.inf, 500.0, 1e4], 6),
        joints=joints(rng) if rng.random() < 0.5 else None,
        soft_finger=drawn_finger(rng) if rng.random() < 0.3 else None,
    )


def drawn_finger(rng):
    grip, sides = float(rng.choice([0.0, 20.0, 80.0])), [3, 4, 8, "exact"][int(rng.integers(4))]
    return cg.SoftFinger(
        float(rng.uniform(0.1, 1)), float(rng.uniform(0.005, 0.05)), grip, str(rng.choice([*"xyz"])), sides
    )


def drawn_limits(rng, cart):
    limits = [TipOver(float(rng.uniform(0, 30)))] if rng.random() < 0.5 else []
    limits += [InternalForce(float(rng.uniform(0, 20)), tuple(rng.normal(size=3)))] if rng.random() < 0.5 else []
    limits += [Skid(float(rng.uniform(0, 0.8)))] if cart.constraints.n_rows == 1 and rng.random() < 0.5 else []
    limits += [SideForce(float(rng.uniform(5, 60)))] if cart.constraints.n_rows and rng.random() < 0.3 else []
    return limits


def drawn_objective(seed, cart):
    objective = OBJECTIVES[seed % len(OBJECTIVES)]
    return None if isinstance(objective, LeastSideForce) and cart.constraints.n_rows == 0 else objective


def excess(arm, wrench, last):
    """By how much a wrench breaks what its arm states, written down again."""
    step = PERIOD * np.array(arm.wrench_rate)
    broken = [np.max(np.abs(wrench) - arm.wrench_limit), np.max(np.abs(wrench - last) - step)]
    broken.append(abs(wrench[2]) - 9.81 * arm.payload)
    if arm.push_only or arm.friction is not None:
        broken.append(-wrench[0])
    if arm.friction is not None:
        broken.append(np.hypot(wrench[1], wrench[2]) - arm.friction.mu * wrench[0])
    if arm.soft_finger is not None:
        finger, axis = arm.soft_finger, "xyz".index(arm.soft_finger.normal)
        borne = [*np.delete(wrench[:3], axis), wrench[3 + axis] / finger.twist_radius]
        pressed = 2 * finger.grip or wrench[axis]
        broken.append(np.linalg.norm(borne) - finger.mu * pressed)
    if arm.joints is not None:
        broken.append(np.max(np.abs(arm.joints.torques(wrench)) - arm.joints.torque_limit))
    return max(broken)


def odd_wrench(rng):
    wrench = rng.uniform((-80, -20, -20), (120, 20, 20)) * rng.choice([1.0, 1.0, 0.1, 10.0])
    if rng.random() < 0.05:
        wrench[rng.integers(3)] = rng.choice([np.nan, np.inf, 1e200])
    return wrench


@pytest.mark.some(30)
@pytest.mark.parametrize("seed", range(60))
def test_answers_are_safe_and_true(seed):
    rng = np.random.default_rng(seed)
    cart = drawn_cart(rng)
    arms = [drawn_arm(rng, f"arm{i}") for i in range(int(rng.integers(1, 4)))]
    limits = drawn_limits(rng, cart)
    planner = WrenchPlanner(
        cart,
        arms,
        objective=drawn_objective(seed, cart),
        cart_limits=limits,
        relax=float(rng.choice([0.0, 5.0, np.inf])),
        switching_cost=30.0 * (seed // len(OBJECTIVES) % 2),
        period=PERIOD,
        search_limit=SearchLimit(60),
    )
    last, motion = {arm.name: np.zeros(6) for arm in arms}, None
    for k in range(5):
        wrench, estimate = odd_wrench(rng), None
        if rng.random() < 0.4:
            motion = Motion(rng.normal(size=3), rng.normal(size=cart.constraints.n_free))
            estimate = cg.Estimate(k * PERIOD, motion, {}, "", cart, cart.parameters)
        plan = planner.plan_or_hold(wrench, estimate=estimate)
        given = plan.contact_wrenches.wrenches
        size = max(1.0, *(float(np.abs(w).max()) for w in given.values()))
        assert plan.status in STATUSES
        for arm in arms:
            assert excess(arm, given[arm.name], last[arm.name]) <= 1e-7 * size
        if plan.status == "optimal":
            basis = cart.constraints.basis_b
            assert basis.T @ plan.contact_wrenches.wrench_b == pytest.approx(basis.T @ wrench, abs=1e-7 * size)
        if plan.is_usable:
            check_floor(cart, limits, motion, plan, 1e-6 * size)
        elif plan.status == "infeasible":
            assert plan.certificate.verified
        last = given


def check_floor(cart, limits, motion, plan, tolerance):
    """Skid and tip-over, of the sum of the hands' wrenches."""
    if not any(isinstance(limit, TipOver | Skid | SideForce) for limit in limits):
        return
    maps = {name: grasp_map_spatial(plan.contacts[name], plan.yaws[name]) for name in plan.wrenches}
    hands = sum(maps[name] @ wrench for name, wrench in plan.wrenches.items())
    floor = FloorReaction.of(cart, motion)
    loads = floor.loads(hands)
    for limit in limits:
        if isinstance(limit, TipOver):
            assert loads.min() >= limit.least_load - tolerance
        elif isinstance(limit, Skid):
            assert abs(floor.lateral(hands)) <= limit.friction * loads[:2].sum() + tolerance
        elif isinstance(limit, SideForce):
            assert abs(floor.lateral(hands)) <= limit.bound + tolerance
