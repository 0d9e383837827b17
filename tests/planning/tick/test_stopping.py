"""What stops a cart that no plan can be given for: the largest share of margins, by a planner for a covariance as much
narrower; rates; that a planner goes on as if it had not been asked; and that no limit pushes a cart away."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp import Arm
from planning import SideForce, Skid, TipOver, WrenchPlanner
from planning.tick.stopping import BEYOND_LIMITS, GENTLE_RATE_RATIO

from ..limits.test_robust import BEND, LEFT, LIMITS, REST, RIGHT, cart, covariance, estimate, hands

CONTACTS = {"left": LEFT, "right": RIGHT}
BRAKE, HARD = np.array([-35.0, 0.0, -3.0]), np.array([-200.0, 0.0, 0.0])
FLAT = {"force_limit": (120.0, 20.0, 4.0), "moment_limit": (8.0, 2.0, 8.0)}
"""Hands that can't hold the cart down."""
RATES = {"wrench_rate": (500.0,) * 3 + (50.0,) * 3}


def planner(warm=True, limits=LIMITS, confidence=0.99, relax=np.inf, **changes):
    made = WrenchPlanner(cart(), hands(**changes), cart_limits=limits, confidence=confidence, relax=relax, period=0.002)
    if warm:
        made.warm_up()
    return made


def stopped(made, told, brake=BRAKE, wrench=HARD):
    """Where nothing near what is asked is wanted."""
    return made.plan_or_hold(wrench, CONTACTS, told, stop=lambda share: brake)


def along(wrenches):
    """In the rows that move the cart."""
    return wrenches.wrench_b[[0, 2]]


SHARES = [(3.5, -5.0, 0.75), (4.0, -20.0, 0.5), (6.0, -35.0, 0.25)]


@pytest.mark.parametrize("warm", [True, False], ids=["compiled", "general"])
@pytest.mark.parametrize(("scale", "force", "share"), SHARES)
def test_as_much_of_the_margins_is_kept_as_leaves_the_stop(warm, scale, force, share):
    """Margins for a covariance of share² are share of them: with the next larger share the stop can't be given. What is
    asked is brought as near as these allow; or, where nothing near will do, the cart is stopped."""
    brake, told = np.array([force, 0.0, 0.0]), estimate(covariance(scale), BEND)
    plan = stopped(planner(warm, relax=0.0, **FLAT), told, brake)
    assert plan.status == "infeasible"
    assert plan.stops == f"stops the cart within {100 * share:g} % of its margins"
    np.testing.assert_allclose(along(plan.held), brake[[0, 2]], atol=1e-6)
    near = stopped(planner(warm, **FLAT), told, brake, (-200.0, 0.0, 0.0))
    assert near.stops == f"keeps {100 * share:g} % of its margins"
    narrow = estimate(covariance(share * scale), BEND)
    wanted = planner(**FLAT).plan_or_hold((-200.0, 0.0, 0.0), CONTACTS, narrow)
    missed = [np.linalg.norm(along(one.contact_wrenches) - HARD[[0, 2]]) for one in (near, wanted)]
    assert missed[0] == pytest.approx(missed[1], rel=1e-5)
    for times, status in ((share, "optimal"), (share + 0.25, "infeasible")):
        told = estimate(covariance(times * scale), BEND)
        assert planner(relax=0.0, **FLAT).plan_or_hold(brake, CONTACTS, told).status == status


def test_a_stop_beyond_the_arms_is_given_as_far_as_they_can():
    weak = planner(force_limit=(10.0, 60.0, 60.0))
    plan = stopped(weak, estimate(covariance(8.0), BEND), np.array([-300.0, 0.0, 0.0]), (-300.0, 0.0, 0.0))
    np.testing.assert_allclose(along(plan.contact_wrenches), [-20.0, 0.0], atol=1e-4)


@pytest.mark.parametrize("warm", [True, False], ids=["compiled", "general"])
@pytest.mark.parametrize("wrench", [HARD, BRAKE], ids=["stops", "keeps"])
def test_it_obeys_rates_from_tick_to_tick(warm, wrench):
    made, last = planner(warm, **RATES), {name: np.zeros(6) for name in CONTACTS}
    for _ in range(8):
        plan = stopped(made, estimate(covariance(8.0), BEND), wrench=wrench)
        for name, given_now in plan.contact_wrenches.wrenches.items():
            assert (np.abs(given_now - last[name]) <= 0.002 * np.array(RATES["wrench_rate"]) + 1e-6).all()
        last = plan.contact_wrenches.wrenches
    assert plan.contact_wrenches.wrench_b[0] == pytest.approx(-16.0, abs=0.5)  # 8 ticks of 2 N


@pytest.mark.parametrize("warm", [True, False], ids=["compiled", "general"])
@pytest.mark.parametrize("seed", [0, 5, 17, 21, 23])
def test_what_stops_the_cart_is_found_with_margins_that_hands_of_any_strength_leave(warm, seed):
    """Limits that are lifted, to see what a stop takes, leave a program that every solver proves."""
    rng = np.random.default_rng(seed)
    yaw, force, moment = rng.uniform(-1, 1), rng.uniform(20, 80, 3), rng.uniform(2, 10, 3)
    hand = Arm("left", [LEFT], yaw=float(yaw), force_limit=force, moment_limit=moment)
    made = WrenchPlanner(cart(), [hand], cart_limits=[SideForce(40.0)], confidence=0.95)
    if warm:
        made.warm_up()
    told, brake = estimate(covariance(), REST), np.array([-5.0, 0.0, -1.0])
    for asked in ((3.0, 1.0, 1.0), (500.0, 0.0, 0.0)):
        plan = made.plan_or_hold(asked, {"left": LEFT}, told, stop=brake.__mul__)
    assert plan.stops == "stops the cart within 100 % of its margins"
    np.testing.assert_allclose(along(plan.held), [-5.0, -1.0], atol=1e-6)


def test_limits_that_no_wrench_keeps_do_not_leave_the_cart_alone():
    """Round a bend that is too fast, whatever is believed."""
    made = planner(limits=[Skid(0.05)], confidence=None, force_limit=(120.0, 1.0, 1.0), moment_limit=(1.0,) * 3)
    fast = BEND._replace(velocity=np.array([3.0, 3.0]))
    plan = stopped(made, estimate(covariance(), fast), np.array([-35.0, 0.0, 0.0]))
    assert plan.status == "infeasible"
    assert plan.stops.endswith(BEYOND_LIMITS)
    np.testing.assert_allclose(along(plan.held), [-35.0, 0.0], atol=1e-6)


def test_where_a_hard_stop_is_beyond_the_limits_a_gentle_one_is_given():
    made = planner(relax=0.0)
    plan = made.plan_or_hold(
        (-300.0, 0.0, 0.0), CONTACTS, estimate(covariance(), REST), stop=np.array([-200.0, 0.0, 0.0]).__mul__
    )
    assert plan.status == "infeasible"
    np.testing.assert_allclose(along(plan.held), [-200.0 * GENTLE_RATE_RATIO, 0.0], atol=1e-6)


def test_the_share_follows_what_is_known_from_tick_to_tick():
    """Down at once, up by a step a tick."""
    made, brake, told = planner(relax=0.0, **FLAT), np.array([-5.0, 0.0, 0.0]), []
    for scale in (6.0, 3.5, 3.5, 3.5, 6.0):
        told.append(stopped(made, estimate(covariance(scale), BEND), brake).stops.split()[4])
    assert told == ["25", "50", "75", "75", "25"]


def test_what_was_asked_last_is_what_the_caller_asked():
    made = planner()
    for wrench in ((30.0, 0.0, 2.0), (-200.0, 0.0, 2.0)):
        stopped(made, estimate(covariance(8.0), BEND), wrench=wrench)
        np.testing.assert_allclose(made.problem().param_dict["wrench"].value, wrench)


def test_afterwards_it_plans_as_ever():
    """With whole margins, from what was given last."""
    made, other = planner(**RATES), planner(**RATES)
    held = stopped(made, estimate(covariance(8.0), BEND)).contact_wrenches
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
    plan = planner().plan_or_hold((20.0, 0.0, 5.0), CONTACTS, told, stop=lambda share: pytest.fail("asked"))
    assert not plan.stops


ASKED = st.tuples(st.floats(-60.0, 60.0), st.floats(-8.0, 8.0))


@pytest.mark.parametrize("warm", [True, False], ids=["compiled", "general"])
@pytest.mark.parametrize("least", [0.0, 30.0, 55.0])
@settings(max_examples=25)
@given(asked=ASKED, scale=st.floats(0.1, 12.0))
def test_limits_never_push_a_cart_that_stands(warm, least, asked, scale):
    """What is given is nearer to what is asked than letting go is, or nothing, whatever the margins are, and where the
    cart as believed breaks a limit alone."""
    made = planner(warm, [TipOver(least)])
    plan = made.plan_or_hold((asked[0], 0.0, asked[1]), CONTACTS, estimate(covariance(scale)), stop=np.zeros(3).__mul__)
    given_now = plan.contact_wrenches.wrench_b[[0, 2]]
    assert np.linalg.norm(given_now - asked) <= np.linalg.norm(asked) + 1e-3
    alone = WrenchPlanner(cart(), hands(), cart_limits=[TipOver(least)]).plan((0.0, 0.0, 0.0), CONTACTS).status
    if alone == "infeasible":
        assert not plan.is_usable
        np.testing.assert_allclose(given_now, 0.0, atol=1e-6)
    if plan.status == "optimal":
        np.testing.assert_allclose(given_now, asked, atol=1e-5)
        whole = planner(warm, [TipOver(least)], relax=0.0).plan_or_hold(
            (asked[0], 0.0, asked[1]), CONTACTS, estimate(covariance(scale))
        )
        assert (whole.status == "optimal") == (not plan.stops)
