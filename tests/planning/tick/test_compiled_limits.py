"""Compiled planning where limits change between ticks: rates, joint torques, the estimated cart, new arms."""

from __future__ import annotations

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.arms import Friction
from cartgrasp.motion import Motion
from cartgrasp.reach import Reach
from planning import WrenchPlanner
from planning.limits import InternalForce, SideForce, Skid, TipOver
from planning.tick.compiled_allocation import SOLVER

from ..contacts.test_contact_choice_with_cart_limits import WHEELS, joints
from ..drawn import arm, cart
from .test_compiled_planning import warm


def loaded_cart(mass):
    inertia = cg.Inertia(mass, (0.3, 0.02), 2.0)
    return cg.CartModel(inertia, cg.RollingConstraints(0.0), wheels=WHEELS, com_height=0.45)


RATE = (4000.0, 4000.0, 4000.0, 900.0, 900.0, 900.0)


def limited_arms(rng, points):
    """With every limit that an arm can state."""
    stated = {"payload": 3.0, "wrench_rate": RATE, "push_only": True, "joints": joints(rng)}
    stated["soft_finger"] = cg.SoftFinger(0.7, 0.1, 40.0, "z")
    return [arm(name, points, **stated) for name in ("left", "right")]


def estimate(rng, time):
    """Of a cart whose mass and motion are known differently at each tick."""
    model = loaded_cart(float(rng.uniform(18, 30)))
    motion = Motion(np.zeros(3), rng.uniform((0.1, -0.3), (1.0, 0.3)))
    return cg.Estimate(time, motion, {}, "", model, model.parameters)


@pytest.mark.parametrize("seed", [0, 1, 2, 5])
def test_all_limits_and_a_cart_that_changes(seed):
    """Rows and bounds that are new at each tick: rates about the last wrench, loads of the estimated cart."""
    rng = np.random.default_rng(seed)
    points = [(-0.25, y, 1.0) for y in rng.uniform(-0.25, 0.25, 1 + 5 * (seed % 2))]
    arms = limited_arms(rng, points)
    options = {"cart_limits": (Skid(0.5), TipOver(30.0), InternalForce(25.0), SideForce(30.0))}
    roads = [make(loaded_cart(24.0), arms, **options) for make in (warm, WrenchPlanner)]
    statuses = []
    for tick in range(25):
        wrench, now = rng.uniform((5, 0, -2), (40, 0, 2)), estimate(rng, float(tick))
        contacts = {n: rng.uniform((-0.3, -0.3, 0.9), (-0.2, 0.3, 1.1)) for n in ("left", "right")}
        given = contacts if tick % 3 == 0 else None
        one, other = (planner.plan(wrench, given, now) for planner in roads)
        assert one.status == other.status
        statuses.append(one.status)
        if one.status == "optimal":
            assert one.solver == SOLVER
            assert one.effort == pytest.approx(other.effort, rel=1e-7, abs=1e-8)
            if all((one.contacts[name] == other.contacts[name]).all() for name in one.contacts):  # else a tie
                assert set(one.active) == set(other.active)
                assert one.margins == pytest.approx(other.margins, abs=1e-6)
            assert min(one.margins.values()) >= -1e-8
            solution = one.proof[1]
            assert solution.status == "optimal"
            assert solution.x == pytest.approx(np.concatenate(list(one.wrenches.values())))
            for planner in roads:
                planner.start_from(one.wrenches)
    assert statuses.count("optimal") > 5


def test_new_arms_are_taken():
    planner = warm(cart(), [arm("left")])
    weak = arm("left", force_limit=(20, 60, 40))
    assert planner.plan((40, 0, 3)).status == "optimal"
    assert planner.plan((40, 0, 3), arms=[weak]).status == "infeasible"
    assert planner.plan((19, 0, 3)).solver == SOLVER
    cone = arm("left", friction=Friction(0.6, "exact"))
    assert planner.plan((40, 0, 3), arms=[cone]).solver != SOLVER
    assert planner.plan((40, 0, 3), arms=[arm("left")]).solver == SOLVER


def test_contacts_beyond_reach_are_refused():
    planner = warm(cart(), [arm("left", reach=Reach.box((-0.8, -0.3, 0.5), (-0.2, 0.3, 1.5)))])
    assert planner.plan((20, 0, 1)).solver == SOLVER
    assert planner.plan((20, 0, 1), {"left": (0.5, 0.2, 1.0)}).status == "infeasible"
    assert planner.plan((20, 0, 1), {"left": (-0.3, 0.1, 1.0)}).solver == SOLVER
