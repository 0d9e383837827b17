"""Limits of the floor for a slope that is learned beside the cart: against the weight's closed forms."""

from statistics import NormalDist

import numpy as np
import pytest

from cartgrasp.arms import Arm
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Motion
from cartgrasp.wheels import GRAVITY
from planning import SideForce, WrenchPlanner
from planning.control.caution import Caution

CART = CartModel(Inertia(24.0, (0.0, 0.0), 2.0))
WEIGHT, BOUND, STD = 24.0 * GRAVITY, 8.0, 0.005
HANDS = [Arm("left", [(-0.25, 0.2, 1.0)]), Arm("right", [(-0.25, -0.2, 1.0)])]


def told(grade_y, std=STD, **changed):
    """The cart at rest, its CoM above the axle and headed along x, on a floor that rises to its left, known so well."""
    p, covariance = len(CART.parameters), np.zeros((len(CART.parameters) + 4,) * 2)
    covariance[p + 1, p + 1] = std**2
    floor = np.array([0.0, grade_y, 0.0, 0.0])
    known = {"covariance": np.zeros((p, p)), "floor": floor, "covariance_on_floor": covariance}
    still = Motion(np.zeros(3), np.zeros(2))
    return Estimate(0.0, still, {}, "ok", CART, CART.parameters, **{**known, **changed})


def across(estimate, confidence=None, bound=BOUND):
    """What the hands give across the wheels, N, of a cart that shall get nothing; and the plan."""
    planner = WrenchPlanner(CART, HANDS, cart_limits=[SideForce(bound)], confidence=confidence)
    plan = planner.plan((0.0, 0.0, 0.0), estimate=estimate)
    assert plan.status == "optimal", plan.message
    return sum(float(wrench[1]) for wrench in plan.wrenches.values()), plan


@pytest.mark.parametrize("grade", [-0.02, 0.01, 0.02])
def test_a_plan_tells_what_wheels_bear_across_a_slope(grade):
    given, plan = across(told(grade))
    assert given == pytest.approx(0.0, abs=1e-6)
    assert plan.wheel_side_force == pytest.approx(WEIGHT * grade)


@pytest.mark.parametrize("grade", [-0.06, 0.05])
def test_hands_bear_what_wheels_may_not(grade):
    given, plan = across(told(grade))
    assert given == pytest.approx(np.sign(grade) * (WEIGHT * abs(grade) - BOUND))
    assert abs(plan.wheel_side_force) == pytest.approx(BOUND)


@pytest.mark.parametrize("widened", [1.0, 2.0])
def test_margins_count_with_what_is_not_known_of_the_slope(widened):
    """Each of two sides holds with half of what may break: 2.58 deviations."""
    caution = Caution(widen={"ok": widened})
    given, _ = across(caution.widened(told(0.03)), confidence=0.99)
    margin = NormalDist().inv_cdf(1 - 0.01 / 2) * widened * WEIGHT * STD
    assert given == pytest.approx(WEIGHT * 0.03 + margin - BOUND)


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ({"floor": np.zeros(2)}, "floor"),
        ({"floor": np.full(4, np.nan)}, "slope.grade_x: nan"),
        ({"covariance_on_floor": None}, "covariance_on_floor"),
        ({"covariance_on_floor": np.zeros((4, 4))}, "covariance_on_floor: shape"),
    ],
)
def test_a_floor_that_is_none_is_refused(changed, why):
    planner = WrenchPlanner(CART, HANDS, cart_limits=[SideForce(BOUND)], confidence=0.99)
    plan = planner.plan((0.0, 0.0, 0.0), estimate=told(0.01, **changed))
    assert plan.status == "invalid_input"
    assert why in plan.message
