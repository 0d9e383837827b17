"""What stops a cart that no plan can be given for: the largest share of margins, by a planner for a covariance as much
narrower; rates; and that a planner goes on as if it had not been asked."""

from __future__ import annotations

import numpy as np
import pytest

from planning import Skid, WrenchPlanner
from planning.tick.stopping import AS_BELIEVED, BEYOND

from ..limits.test_robust import BEND, LEFT, LIMITS, REST, RIGHT, cart, covariance, estimate, hands

CONTACTS = {"left": LEFT, "right": RIGHT}
BRAKE = np.array([-35.0, 0.0, -3.0])
FLAT = {"force_limit": (120.0, 20.0, 4.0), "moment_limit": (8.0, 2.0, 8.0)}
"""Hands that can't hold the cart down."""
RATES = {"wrench_rate": (500.0,) * 3 + (50.0,) * 3}


def planner(warm=True, limits=LIMITS, confidence=0.99, relax=np.inf, **changes):
    made = WrenchPlanner(cart(), hands(**changes), cart_limits=limits, confidence=confidence, relax=relax, period=0.002)
    if warm:
        made.warm_up()
    return made


def stopped(made, told, brake=BRAKE, wrench=(30.0, 0.0, 0.0)):
    return made.plan_or_hold(wrench, CONTACTS, told, stop=lambda: brake)


def along(plan):
    """What is held, in the rows that move the cart."""
    return plan.held.wrench_b[[0, 2]]


@pytest.mark.parametrize("warm", [True, False], ids=["compiled", "general"])
@pytest.mark.parametrize(("scale", "force", "share"), [(3.5, -5.0, 0.75), (4.0, -20.0, 0.5), (6.0, -35.0, 0.25)])
def test_as_much_of_the_margins_is_kept_as_leaves_the_wrench(warm, scale, force, share):
    """Margins for a covariance of share² are share of them: with the next larger share the wrench can't be given."""
    brake = np.array([force, 0.0, 0.0])
    plan = stopped(planner(warm, **FLAT), estimate(covariance(scale), BEND), brake)
    assert plan.status == "infeasible"
    assert plan.stops == f"stops the cart within {100 * share:g} % of its margins"
    np.testing.assert_allclose(along(plan), brake[[0, 2]], atol=1e-6)
    for times, status in ((share, "optimal"), (share + 0.25, "infeasible")):
        told = estimate(covariance(times * scale), BEND)
        assert planner(relax=0.0, **FLAT).plan_or_hold(brake, CONTACTS, told).status == status


def test_a_wrench_beyond_the_arms_is_given_as_far_as_they_can():
    weak = planner(force_limit=(10.0, 60.0, 60.0))
    plan = stopped(weak, estimate(covariance(8.0), BEND), np.array([-300.0, 0.0, 0.0]))
    np.testing.assert_allclose(along(plan), [-20.0, 0.0], atol=1e-4)


@pytest.mark.parametrize("warm", [True, False], ids=["compiled", "general"])
def test_it_obeys_rates_from_tick_to_tick(warm):
    made, last = planner(warm, **RATES), {name: np.zeros(6) for name in CONTACTS}
    for _ in range(8):
        plan = stopped(made, estimate(covariance(8.0), BEND))
        for name, wrench in plan.held.wrenches.items():
            assert (np.abs(wrench - last[name]) <= 0.002 * np.array(RATES["wrench_rate"]) + 1e-6).all()
        last = plan.held.wrenches
    assert plan.held.wrench_b[0] == pytest.approx(-16.0, abs=0.5)  # 8 ticks of 2 N


def test_limits_that_no_wrench_keeps_do_not_leave_the_cart_alone():
    """Round a bend that is too fast, whatever is believed."""
    made = planner(limits=[Skid(0.05)], confidence=None, force_limit=(120.0, 1.0, 1.0), moment_limit=(1.0,) * 3)
    fast = BEND._replace(velocity=np.array([3.0, 3.0]))
    plan = stopped(made, estimate(covariance(), fast), np.array([-35.0, 0.0, 0.0]))
    assert plan.status == "infeasible"
    assert plan.stops.endswith(BEYOND)
    np.testing.assert_allclose(along(plan), [-35.0, 0.0], atol=1e-6)


def test_where_it_is_beyond_the_limits_themselves_the_nearest_within_is_given():
    made = planner()
    plan = stopped(made, estimate(covariance(8.0), REST), np.array([-200.0, 0.0, 0.0]))
    assert plan.stops.endswith(AS_BELIEVED)
    given = plan.held.wrench_b
    assert -200.0 < given[0] < -20.0
    believed = planner(confidence=None).plan_or_hold((-200.0, 0.0, 0.0), CONTACTS, estimate(covariance(), REST))
    np.testing.assert_allclose(given, believed.cart_wrench, atol=1e-3)


def test_the_share_follows_what_is_known_from_tick_to_tick():
    """Down at once, up by a step a tick."""
    made, brake, told = planner(**FLAT), np.array([-5.0, 0.0, 0.0]), []
    for scale in (6.0, 3.5, 3.5, 3.5, 6.0):
        told.append(stopped(made, estimate(covariance(scale), BEND), brake).stops.split()[4])
    assert told == ["25", "50", "75", "75", "25"]


def test_what_was_asked_last_is_what_the_caller_asked():
    made = planner()
    stopped(made, estimate(covariance(8.0), BEND), wrench=(30.0, 0.0, 2.0))
    np.testing.assert_allclose(made.problem().param_dict["wrench"].value, [30.0, 0.0, 2.0])


def test_afterwards_it_plans_as_ever():
    """With whole margins, from what was given last."""
    made, other = planner(**RATES), planner(**RATES)
    held = stopped(made, estimate(covariance(8.0), BEND)).held
    other.start_from(held.wrenches, CONTACTS)
    for _ in range(3):
        plans = [one.plan_or_hold((20.0, 0.0, 5.0), CONTACTS, estimate(covariance(0.5), BEND)) for one in (made, other)]
        assert plans[0].is_usable
        assert not plans[0].stops
        np.testing.assert_allclose(plans[0].cart_wrench, plans[1].cart_wrench, atol=1e-6)


@pytest.mark.parametrize(
    "told", [estimate(covariance(0.5), BEND), estimate(covariance(8.0), BEND)._replace(time=np.nan)]
)
def test_a_plan_that_is_there_and_one_that_is_refused_ask_for_no_stop(told):
    plan = planner().plan_or_hold((20.0, 0.0, 5.0), CONTACTS, told, stop=lambda: pytest.fail("asked"))
    assert not plan.stops
