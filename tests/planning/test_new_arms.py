"""Arms with other limits, weights and yaws, or that hold elsewhere: what is compiled is filled anew, and answers as a
planner made for these arms does."""

from __future__ import annotations

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.motion import Estimate, Motion
from planning import InternalForce, LeastInternalForce, Skid, Smoothness, TipOver, WrenchPlanner

from .contacts.test_contact_choice_with_cart_limits import joints, shopping_cart

PLACES = {"left": [(-0.25, 0.2, 1.0)], "right": [(-0.25, -0.2, 1.0), (-0.25, -0.1, 0.9)]}
FIELDS = ("yaw", "force", "weights", "friction", "push_only", "payload", "joints", "rate")


def drawn_arms(rng, new=FIELDS):
    """Of `FIELDS`, those in `new` are drawn, and with `places` where they hold."""
    arms = []
    for name, points in PLACES.items():
        if "places" in new:
            points = rng.uniform((-0.3, -0.3, 0.8), (-0.2, 0.3, 1.2), (int(rng.integers(1, 4)), 3)).tolist()
        drawn = {
            "yaw": ("yaw", float(rng.uniform(-0.5, 0.5))),
            "force": ("force_limit", rng.uniform(20, 80, 3).tolist()),
            "weights": ("weights", rng.uniform(0.5, 12, 6).tolist()),
            "friction": ("friction", cg.Friction(float(rng.uniform(0.2, 0.9)), int(rng.integers(3, 6)))),
            "push_only": ("push_only", bool(rng.random() < 0.5)),
            "payload": ("payload", float(rng.uniform(1, 5))),
            "joints": ("joints", joints(rng)),
            "rate": ("wrench_rate", rng.uniform(1e3, 1e5, 6).tolist()),
        }
        stated = [drawn[field] for field in new if field in drawn and rng.random() < 0.7]
        arms.append(cg.Arm(name, points, **dict(stated)))
    return arms


def assert_alike(plan, expected):
    assert plan.status == expected.status
    if not plan.is_usable:
        return
    assert plan.effort == pytest.approx(expected.effort, rel=1e-6, abs=1e-6)
    assert plan.residuals.feasible
    assert plan.margins.keys() == expected.margins.keys()
    for name, wrench in plan.wrenches.items():
        assert wrench == pytest.approx(expected.wrenches[name], abs=1e-4)


@pytest.mark.some(15)
@pytest.mark.parametrize("objective", [None, Smoothness(0.5), LeastInternalForce(2.0)])
@pytest.mark.parametrize("limits", [(), (Skid(0.05), TipOver(30.0)), (InternalForce(3.0), TipOver(30.0))])
@pytest.mark.parametrize("new", [FIELDS, ("force",), ("yaw", "force"), ("weights",), ("places", "yaw")])
def test_they_are_those_of_a_new_planner(objective, limits, new):
    rng, cart = np.random.default_rng(len(new)), shopping_cart()
    planner = WrenchPlanner(cart, drawn_arms(rng, new), objective=objective, cart_limits=limits)
    planner.warm_up()
    solved = 0
    for k in range(12):
        arms, wrench = drawn_arms(rng, new), rng.uniform((5, 0, -4), (50, 0, 4))
        more = {"contacts": {name: points[0] for name, points in PLACES.items()}} if k % 3 == 0 else {}
        if k % 4 == 0:
            motion = Motion(np.zeros(3), rng.uniform(-0.5, 0.5, 2))
            cart = cart.with_inertia(cg.Inertia(float(rng.uniform(15, 40)), (0.3, 0.0), 2.0))
            more["estimate"] = estimate = Estimate(0.0, motion, {}, "", cart, cart.parameters)
        planner.reset()
        fresh = WrenchPlanner(cart, arms, objective=objective, cart_limits=limits)
        plan = planner.plan(wrench, arms=arms, **more)
        assert_alike(plan, fresh.plan(wrench, **{**more, "estimate": estimate}))
        solved += plan.is_usable
    assert solved >= 4


def test_other_limits_of_the_same_structure_are_filled_in_place():
    planner = WrenchPlanner(shopping_cart(), drawn_arms(np.random.default_rng(0), ()), cart_limits=[TipOver()])
    planner.warm_up()
    compiled, given = planner._now.compiled, {name: points[0] for name, points in PLACES.items()}
    for force in (30.0, 20.0, 40.0):
        arms = [cg.Arm(name, points, force_limit=(force,) * 3) for name, points in PLACES.items()]
        plan = planner.plan((1.9 * force, 0.0, 0.0), given, arms=arms)
        assert planner._now.compiled is compiled
        assert plan.solver == "dual active set"
        assert plan.margins["left: fx upper"] == pytest.approx(force - plan.wrenches["left"][0], abs=1e-9)
        assert planner.plan((2.1 * force, 0.0, 0.0), given).status == "infeasible"
    frictional = [cg.Arm(name, points, friction=cg.Friction(0.6)) for name, points in PLACES.items()]
    assert planner.plan((20.0, 0.0, 0.0), given, arms=frictional).status == "optimal"
    assert planner._now.compiled is not compiled


def test_arms_that_hold_elsewhere_keep_the_workspace():
    planner = WrenchPlanner(shopping_cart(), drawn_arms(np.random.default_rng(0), ()))
    planner.warm_up()
    workspace, given = planner._now.compiled._allocation, {name: points[0] for name, points in PLACES.items()}
    for y in (0.1, 0.3):
        arms = [cg.Arm("left", [(-0.25, y, 1.0)]), cg.Arm("right", [(-0.25, -y, 1.0), (-0.25, -0.2, 1.0)])]
        plan = planner.plan((20.0, 0.0, 2.0), arms=arms)
        assert_alike(plan, WrenchPlanner(shopping_cart(), arms).plan((20.0, 0.0, 2.0)))
        assert plan.solver == planner.plan((20.0, 0.0, 2.0), given).solver == "dual active set"
        assert planner._now.compiled._allocation is workspace


def test_numbers_where_there_were_zeros():
    """Arms that stand straight and slip, and then neither: rows get numbers in other columns."""

    def pair(yaw, mu, torque):
        joint = cg.JointTorques(np.outer([0.5, torque, 0, 0, 0, 0], [1.0, 0.0]), np.zeros(2), np.full(2, 12.0))
        return [
            cg.Arm(name, points[:1], yaw=yaw, friction=cg.Friction(mu), joints=joint) for name, points in PLACES.items()
        ]

    planner = WrenchPlanner(shopping_cart(), pair(0.0, 0.0, 0.0))
    planner.warm_up()
    compiled = planner._now.compiled
    for arms in (pair(0.0, 0.6, 0.0), pair(0.4, 0.6, 0.0), pair(-0.4, 0.0, 0.0), pair(0.3, 0.4, 0.8)):
        plan = planner.plan((20.0, 0.0, 2.0), arms=arms)
        assert_alike(plan, WrenchPlanner(shopping_cart(), arms).plan((20.0, 0.0, 2.0)))
        assert planner._now.compiled is compiled
        assert plan.message == ""


def test_rows_that_look_at_no_arm_stay():
    """An internal force looks at yaws: its rows are new with them, also beside rows that aren't."""
    arms = [cg.Arm(name, points[:1]) for name, points in PLACES.items()]
    turned = [cg.Arm(name, points[:1], yaw=1.0) for name, points in PLACES.items()]
    for limits, stays in (([TipOver(5.0), Skid(0.6)], True), ([TipOver(5.0), InternalForce(3.0)], False)):
        planner = WrenchPlanner(shopping_cart(), arms, cart_limits=limits)
        rows = planner._now.terms.base.cart_rows
        planner.plan((20.0, 0.0, 0.0), arms=turned)
        assert (planner._now.terms.base.cart_rows is rows) == stays
