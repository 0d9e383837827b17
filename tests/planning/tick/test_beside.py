"""What others give besides: the same plan as where an arm's rate of change leaves it no choice but to give that."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cartgrasp as cg
from cartgrasp.motion import Motion
from planning import LeastSideForce, Skid, TipOver, WeightedWrench, WrenchPlanner

from ..limits.test_robust import cart, covariance, estimate

PLACES = {"left": (-0.25, 0.2, 1.0), "right": (-0.25, -0.2, 1.0)}
LIMITS = [TipOver(20.0), Skid(0.5)]
MOTION = Motion(np.zeros(3), np.array([0.5, 0.3]))
NUMBERS = st.floats(-1.0, 1.0)


def arm(name, rate=np.inf):
    return cg.Arm(
        name, [PLACES[name]], force_limit=(150.0,) * 3, moment_limit=(20.0,) * 3, yaw=0.3, wrench_rate=(rate,) * 6
    )


def planners(wrench, objective, warm, **options):
    """One for both arms, of which the right one gives a wrench (6,) and nothing else; and one for the left."""
    options |= {"objective": objective, "relax": np.inf, "period": 1e-3}
    both = WrenchPlanner(cart(), [arm("left"), arm("right", 1e-4)], **options)
    left = WrenchPlanner(cart(), [arm("left")], **options)
    if warm:
        both.warm_up()
        left.warm_up()
    both.start_from({"right": wrench})
    return both, left


@pytest.mark.parametrize("warm", [False, True])
@pytest.mark.parametrize("confidence", [None, 0.99])
@pytest.mark.parametrize("objective", [WeightedWrench(), LeastSideForce(2.0)], ids=lambda o: type(o).__name__)
@settings(max_examples=15)
@given(asked=st.tuples(*[NUMBERS] * 3), besides=st.lists(NUMBERS, min_size=6, max_size=6))
def test_it_is_planned_for_what_is_left(warm, confidence, objective, asked, besides):
    asked, besides = np.array(asked) * (80.0, 30.0, 10.0), np.array(besides) * ([40.0] * 3 + [8.0] * 3)
    told = estimate(covariance(), MOTION)
    both, left = planners(besides, objective, warm, cart_limits=LIMITS, confidence=confidence)
    whole = both.plan_or_hold(asked, PLACES, told)
    own = cg.ContactWrenches({"right": besides}, {"right": PLACES["right"]}, {"right": 0.3})
    plan = left.plan_or_hold(asked, {"left": PLACES["left"]}, told, beside=own)
    assert plan.status == whole.status in ("optimal", "relaxed")
    np.testing.assert_allclose(plan.wrenches["left"], whole.wrenches["left"], atol=1e-4)
    np.testing.assert_allclose(plan.cart_wrench, whole.cart_wrench, atol=1e-4)
    np.testing.assert_allclose(plan.wheel_loads, whole.wheel_loads, atol=1e-4)
    assert plan.wheel_side_force == pytest.approx(whole.wheel_side_force, abs=1e-4)
    posed = left.problem(asked, {"left": PLACES["left"]})
    if plan.status == "optimal" and confidence is None:
        posed.solve(solver="CLARABEL")
        assert posed.status == "optimal"


def test_the_next_call_forgets_it():
    _, left = planners(np.zeros(6), None, True, cart_limits=LIMITS)
    own = cg.ContactWrenches({"right": np.array([30.0, 0, 0, 0, 0, 0])}, {"right": PLACES["right"]})
    before = left.plan_or_hold((40.0, 0.0, 2.0))
    assert np.abs(left.plan_or_hold((40.0, 0.0, 2.0), beside=own).wrenches["left"] - before.wrenches["left"])[0] > 20
    after = left.plan_or_hold((40.0, 0.0, 2.0))
    np.testing.assert_array_equal(after.wrenches["left"], before.wrenches["left"])
    np.testing.assert_array_equal(after.wheel_loads, before.wheel_loads)


@pytest.mark.parametrize(
    "beside", [{"right": np.zeros(6)}, cg.ContactWrenches({"right": np.full(6, np.nan)}, {"right": np.zeros(3)})]
)
def test_what_is_no_wrench_is_refused(beside):
    _, left = planners(np.zeros(6), None, False)
    plan = left.plan_or_hold((40.0, 0.0, 2.0), beside=beside)
    assert plan.status == "invalid_input"
    assert plan.message.startswith("beside: ")
