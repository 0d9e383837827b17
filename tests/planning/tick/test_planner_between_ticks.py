"""What may change from call to call (arms, the estimate's cart, the last wrench), and what is relaxed or proposed."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cartgrasp as cg
from cartgrasp.constraints import RollingConstraints
from cartgrasp.motion import Motion
from planning import InternalForce, LeastSideForce, Skid, TipOver, WrenchPlanner, allocate

from ..contacts.test_contact_choice_with_cart_limits import joints, shopping_cart
from ..drawn import arm, bar, cart, first_contacts, random_arms, violation


def pair(**changes):
    return [arm("left", [(-0.25, 0.2, 1.0)], **changes), arm("right", [(-0.25, -0.2, 1.0)])]


# --- relaxed ------------------------------------------------------------------------------------------------


def test_a_relaxed_plan_is_the_nearest():
    planner = WrenchPlanner(cart(), pair(), relax=np.inf)
    plan = planner.plan((150, 0, 2))
    assert plan.status == "relaxed"
    assert plan.contact_wrenches.wrench_b[[0, 2]] == pytest.approx([120, 2], abs=1e-8)
    assert plan.missing == pytest.approx({"fx": 30.0, "tau": 0.0}, abs=1e-8)
    assert set(plan.active) >= {"left: fx upper", "right: fx upper"}
    assert plan.certificate.verified
    assert plan.message == plan.certificate.words
    assert plan.residuals.feasible
    assert min(plan.margins.values()) >= -1e-8
    assert plan.effort == pytest.approx(allocate(cart(), pair(), first_contacts(pair()), (120, 0, 2)).effort, rel=1e-7)
    document = json.loads(json.dumps(plan.as_dict(), allow_nan=False))
    assert document["status"] == "relaxed"
    assert document["missing"]["fx"] == pytest.approx(30)
    assert document["arms"]["left"]["wrench"][0] == pytest.approx(60)


def test_only_so_far_as_is_allowed():
    near = WrenchPlanner(cart(), pair(), relax=10.0)
    assert near.plan((129.9, 0, 0)).status == "relaxed"
    assert near.plan((130.1, 0, 0)).status == "infeasible"
    assert WrenchPlanner(cart(), pair()).plan((120.1, 0, 0)).status == "infeasible"
    with pytest.raises(cg.UsageError, match="relax"):
        WrenchPlanner(cart(), pair(), relax=-1.0)


@pytest.mark.parametrize(
    ("hand", "choices"), [(bar("hand"), "all"), (arm("hand", [(-0.25, 0.2, 1.0), (-0.25, 0.0, 1.0)]), "2")]
)
def test_how_many_choices_were_tried_is_told(hand, choices):
    plan = WrenchPlanner(cart(), [hand]).plan((500, 0, 0))
    assert plan.message.endswith(f"(at the nearest of {choices} choices of contacts; none is feasible)")


def test_relaxed_over_contacts():
    planner = WrenchPlanner(cart(), [bar("left"), bar("right")], min_hand_distance=0.2, relax=np.inf)
    plan = planner.plan((150, 0, 0))
    assert plan.status == "relaxed"
    assert plan.contact_wrenches.wrench_b[0] == pytest.approx(120)
    assert abs(plan.contacts["left"][1] - plan.contacts["right"][1]) >= 0.2 - 1e-9


anything = st.floats(-1e4, 1e4) | st.floats(allow_nan=True, allow_infinity=True)


@settings(max_examples=80, deadline=None)
@given(st.lists(st.tuples(anything, anything, anything), min_size=1, max_size=4))
def test_relaxing_is_safe_and_never_farther_than_holding(wrenches):
    arms, basis = pair(), cart().constraints.basis_b
    planner, holding = WrenchPlanner(cart(), arms, relax=np.inf), WrenchPlanner(cart(), arms)
    for wrench in wrenches:
        plan, held = planner.plan_or_hold(wrench), holding.plan_or_hold(wrench)
        given_back = plan.contact_wrenches
        assert violation(arms, given_back.wrenches) <= 1e-6
        if plan.status == "relaxed":
            missed = np.linalg.norm(basis.T @ (given_back.wrench_b - wrench))
            held_missed = np.linalg.norm(basis.T @ (held.contact_wrenches.wrench_b - wrench))
            assert missed <= held_missed * (1 + 1e-6) + 1e-6
            assert missed == pytest.approx(np.linalg.norm(list(plan.missing.values())), rel=1e-6, abs=1e-6)


# --- rates of change ----------------------------------------------------------------------------------------


def test_a_wrench_changes_by_no_more_than_its_rate():
    """100 N/s for 10 ms is 1 N a call, from zero on; what is held shrinks no faster."""
    rate = (100, 100, 100, 20, 20, 20)
    arms = [arm("left", friction=None, wrench_rate=rate), arm("right", [(-0.25, -0.2, 1.0)], wrench_rate=rate)]
    planner = WrenchPlanner(cart(), arms, period=0.01, relax=np.inf)
    last, pushed = np.zeros(12), []
    for wrench in [(40, 0, 3)] * 30 + [(np.nan, 0, 0)] * 5 + [(-40, 0, 0)] * 40:
        plan = planner.plan_or_hold(wrench)
        now = np.concatenate(list(plan.contact_wrenches.wrenches.values()))
        assert (np.abs(now - last) <= np.tile([1, 1, 1, 0.2, 0.2, 0.2], 2) + 1e-9).all()
        last = now
        pushed.append((plan.status, plan.contact_wrenches.wrench_b[0]))
    assert pushed[0] == ("relaxed", pytest.approx(2.0, abs=0.05))
    assert "left: fx rate upper" in WrenchPlanner(cart(), arms, period=0.01, relax=np.inf).plan((40, 0, 0)).active
    assert pushed[29] == ("optimal", pytest.approx(40.0))
    assert [status for status, _ in pushed[30:35]] == ["invalid_input"] * 5
    assert pushed[34][1] == pytest.approx(40.0 - 5 * 2.0, rel=0.05)  # 1 N a call for each hand
    assert pushed[-1][1] < 0


def test_within_its_rate_a_plan_is_as_without():
    rated = [arm("left", wrench_rate=(1e5,) * 6), arm("right", [(-0.25, -0.2, 1.0)], wrench_rate=(1e5,) * 6)]
    planner, plain = WrenchPlanner(cart(), rated), WrenchPlanner(cart(), pair())
    for wrench in ((40, 0, 3), (20, 0, 5), (55, 0, -2)):
        assert planner.plan(wrench).effort == pytest.approx(plain.plan(wrench).effort, rel=1e-9)


def test_contact_choice_knows_the_rate():
    """From a held wrench only a few contacts can serve the next one; brute force over planners of the same past."""
    rng = np.random.default_rng(1)
    points = [[(-0.25, y, 1.0) for y in np.linspace(-0.25, 0.25, 7)]] * 2
    arms = [arm(n, p, wrench_rate=(4e3,) * 3 + (6e2,) * 3) for n, p in zip(("left", "right"), points, strict=True)]
    for _ in range(6):
        first, second = rng.uniform((20, 0, -2), (50, 0, 2)), rng.uniform((20, 0, -6), (50, 0, 6))
        held = {"left": points[0][5], "right": points[0][1]}
        best = np.inf
        for one in points[0]:
            for other in points[1]:
                planner = WrenchPlanner(cart(), arms, period=1e-2)
                planner.plan(first, contacts=held)
                plan = planner.plan_or_hold(second, contacts={"left": one, "right": other})
                best = min(best, plan.effort) if plan.status == "optimal" else best
        planner = WrenchPlanner(cart(), arms, period=1e-2)
        planner.plan(first, contacts=held)
        plan = planner.plan_or_hold(second)
        assert plan.status == ("optimal" if np.isfinite(best) else "infeasible")
        if plan.status == "optimal":
            assert plan.effort == pytest.approx(best, rel=1e-8)


# --- arms ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(8))
def test_new_arms_are_as_a_new_planner(seed):
    rng = np.random.default_rng(seed)
    arms = random_arms(rng, 2)
    planner = WrenchPlanner(cart(), arms)
    for _ in range(5):
        wrench = rng.uniform((0, 0, -6), (60, 0, 6))
        (new, _) = random_arms(rng, 2, n_points=int(rng.integers(1, 3)))
        new = cg.Arm(
            "arm0", new.contacts, yaw=new.yaw, force_limit=new.force_limit, friction=new.friction, joints=joints(rng)
        )
        arms = [new, arms[1]]
        plan, fresh = planner.plan_or_hold(wrench, arms=arms), WrenchPlanner(cart(), arms).plan_or_hold(wrench)
        assert plan.status == fresh.status
        if plan.status == "optimal":
            assert plan.effort == pytest.approx(fresh.effort, rel=1e-8)
            assert plan.yaws == fresh.yaws
            again = planner.plan_or_hold(wrench)  # they stay
            assert again.effort == pytest.approx(fresh.effort, rel=1e-8)


def test_a_wrench_that_new_limits_forbid_is_not_held():
    planner = WrenchPlanner(cart(), pair())
    assert planner.plan((100, 0, 0)).status == "optimal"
    weak = arm("left", force_limit=(10, 60, 40))
    held = planner.plan_or_hold((np.nan, 0, 0)).contact_wrenches.wrenches["left"]
    assert held[0] > 10
    assert planner.plan((100, 0, 0), arms=[weak, pair()[1]]).status == "infeasible"
    held = planner.plan_or_hold((np.nan, 0, 0)).contact_wrenches.wrenches["left"]
    assert 0 < held[0] <= 10


@pytest.mark.parametrize("sides", [8, "exact"])
def test_what_is_held_is_scaled_into_new_limits_no_more_than_need_be(sides):
    """A weaker grip that still bears what is held changes nothing; one of half of it is 60 N. From a cone it had been
    let go of at once, whatever rate the arm states."""

    def pinch(grip):
        fingers = cg.SoftFinger(0.6, 0.0156, grip, "z", sides)
        return arm("left", force_limit=(150, 60, 40), friction=None, soft_finger=fingers, wrench_rate=(50,) * 6)

    planner = WrenchPlanner(cart(), [pinch(100.0)], period=0.01)
    planner.start_from({"left": (100, 0, 0, 0, 0, 0)})
    for grip, most in ((100.0, 100.0), (90.0, 100.0), (50.0, 60.0)):
        plan = planner.plan_or_hold((np.nan, 0, 0), arms=[pinch(grip)])
        held = plan.contact_wrenches.wrenches["left"]
        assert most - 2.0 < held[0] <= most + 1e-9


def test_what_is_held_comes_to_the_edge_of_a_cone():
    """That of the ellipsoid on the way to (40, 45) N with 0.6 N·m, by its formula."""
    asked = np.array([40, 45, 0, 0, 0, 0.6])
    edge = asked * 0.6 * 2 * 50.0 / np.linalg.norm([40, 45, 0.6 / 0.0156])
    fingers = cg.SoftFinger(0.6, 0.0156, 50.0, "z", "exact")
    planner = WrenchPlanner(cart(), [arm("left", friction=None, soft_finger=fingers)], period=1e-6)
    planner.start_from({"left": asked})
    assert planner.plan_or_hold((np.nan, 0, 0)).held.wrenches["left"] == pytest.approx(edge, rel=1e-4)


def test_new_arms_count_even_if_the_wrench_is_refused():
    planner = WrenchPlanner(cart(), pair())
    planner.plan((100, 0, 0))
    plan = planner.plan_or_hold((np.nan, 0, 0), arms=[arm("left", force_limit=(10, 60, 40))])
    assert plan.status == "invalid_input"
    assert 0 < plan.contact_wrenches.wrenches["left"][0] <= 10


def test_starting_from_a_wrench():
    rated = [arm("left", wrench_rate=(1e3,) * 6), arm("right", [(-0.25, -0.2, 1.0)])]
    planner = WrenchPlanner(cart(), rated, period=1e-3)
    planner.start_from({"left": (30, 0, 0, 0, 0, 0)})
    assert planner.plan((60, 0, 0)).wrenches["left"][0] == pytest.approx(30, abs=1 + 1e-9)
    for wrong in ({"left": (np.nan,) * 6}, {"middle": (0,) * 6}):
        with pytest.raises(cg.UsageError, match="start_from"):
            planner.start_from(wrong)


def test_arms_that_are_refused_change_nothing():
    planner = WrenchPlanner(cart(), pair())
    before = planner.plan((40, 0, 3))
    assert (
        planner.plan((40, 0, 3), arms=[arm("middle")]).message
        == "arms: there is no arm 'middle'; there are left, right"
    )
    far = arm("left", reach=cg.Reach.box((0, 0, 0), (1, 1, 1)))
    refused = planner.plan((40, 0, 3), arms=[far])
    assert refused.status == "invalid_input"
    assert "no candidate contact is within; the nearest is 0.25 m beyond" in refused.message
    assert planner.plan((40, 0, 3)).effort == pytest.approx(before.effort)


def test_arms_that_are_refused_leave_the_carts_limits():
    """Also where what is given besides has these stated anew."""
    planner, same = (WrenchPlanner(cart(), pair(), cart_limits=[InternalForce(1.0)]) for _ in range(2))
    far = arm("left", yaw=1.5, reach=cg.Reach.box((0, 0, 0), (1, 1, 1)))
    assert planner.plan((40, 0, 3), arms=[far, pair()[1]]).status == "invalid_input"
    beside = cg.ContactWrenches({"other": np.ones(6)}, {"other": np.zeros(3)}, {"other": 0.0})
    found, expected = (one.plan_or_hold((40, 0, 3), beside=beside) for one in (planner, same))
    assert found.status == "optimal"
    assert found.wrenches["left"] == pytest.approx(expected.wrenches["left"], abs=1e-6)


# --- postures -----------------------------------------------------------------------------------------------


class SamePosture:
    """An arm whose joints bear the same wherever its hand is."""

    bears = cg.JointTorques(np.eye(6), np.zeros(6), np.full(6, 200.0))

    def joints_at(self, contact, yaw):
        return self.bears


@pytest.mark.parametrize("is_warm", [False, True])
def test_postures_at_chosen_contacts_are_planned_for_once_a_tick(is_warm):
    """Rates of change and moves count from what was given, not from the plan by which contacts were chosen."""
    places = [(-0.25, 0.2, 1.0), (-0.25, -0.2, 1.0)]
    found = []
    for postures in (SamePosture(), SamePosture.bears):
        hand = cg.Arm("hand", places, wrench_rate=(1e3,) * 6, joints=postures)
        planner = WrenchPlanner(cart(), [hand], period=0.01, relax=np.inf, switching_cost=1.0)
        if is_warm:
            planner.warm_up()
        wrenches = [(60, 0, 4)] * 2 + [(20, 0, 4), (20, 0, -4)] * 2
        found.append([planner.plan_or_hold(wrench) for wrench in wrenches])
    for plan, expected in zip(*found, strict=True):
        assert (plan.status, plan.switched) == (expected.status, expected.switched)
        assert plan.wrenches["hand"] == pytest.approx(expected.wrenches["hand"], abs=1e-4)
    assert found[0][0].wrenches["hand"][0] == pytest.approx(10.0, abs=1e-4)
    assert any(plan.switched for plan in found[0])


# --- reach --------------------------------------------------------------------------------------------------


def test_contacts_are_chosen_within_reach():
    free, short = bar("hand"), bar("hand", reach=cg.Reach.box((-1, -0.05, 0), (1, 0.3, 2)))
    assert WrenchPlanner(cart(), [free]).plan((40, 0, 8)).contacts["hand"][1] < -0.1
    planner = WrenchPlanner(cart(), [short])
    assert planner.plan((40, 0, 7)).contacts["hand"][1] == pytest.approx(-0.05, abs=1e-9)
    given = planner.plan((40, 0, 2), contacts={"hand": (-0.25, -0.15, 1.0)})
    assert given.status == "infeasible"
    assert given.certificate.words == "hand: reach: the contact is 0.1 m beyond it"
    assert given.certificate.verified
    assert planner.plan((40, 0, 2), contacts={"hand": (-0.25, -0.05, 1.0)}).status == "optimal"


# --- estimates ----------------------------------------------------------------------------------------------


def estimate(time, model, velocity=(0.0, 0.0)):
    return cg.Estimate(time, Motion(np.zeros(3), np.array(velocity)), {}, "", model, model.parameters)


def test_the_estimate_says_what_tips():
    """Braking a cart whose load turns out to lie far back lifts its front sooner."""
    arms = [arm("left", friction=None), arm("right", [(-0.25, -0.2, 1.0)], friction=None)]
    planner = WrenchPlanner(shopping_cart(), arms, cart_limits=[TipOver(5.0)], relax=np.inf)
    hard = planner.plan((-110, 0, 0))
    assert hard.status == "optimal"
    back = shopping_cart().with_inertia(cg.Inertia(24.0, (0.12, 0.02), 2.0))
    softer = planner.plan((-110, 0, 0), estimate=estimate(1.0, back))
    assert softer.status == "relaxed" or softer.effort > hard.effort
    assert any("wheel" in name for name in softer.active)
    fresh = WrenchPlanner(back, arms, cart_limits=[TipOver(5.0)], relax=np.inf).plan((-110, 0, 0))
    assert softer.effort == pytest.approx(fresh.effort, rel=1e-8)
    assert planner.plan((-110, 0, 0)).effort == pytest.approx(fresh.effort, rel=1e-8)  # it stays
    again = planner.plan((-110, 0, 0), estimate=estimate(1.1, shopping_cart()))
    assert again.effort == pytest.approx(hard.effort, rel=1e-8)


def test_an_estimate_given_again_costs_nothing_and_still_holds():
    """A loop may hand over the filter's last estimate at every tick."""
    back = shopping_cart().with_inertia(cg.Inertia(24.0, (0.12, 0.02), 2.0))
    limits, stronger = [Skid(0.5), TipOver(5.0)], pair(force_limit=(80, 60, 40), friction=None)
    planner, known = WrenchPlanner(shopping_cart(), pair(friction=None), cart_limits=limits, relax=np.inf), []
    for model in (back, shopping_cart(), back):
        known.append(estimate(1.0, model))
        fresh = WrenchPlanner(model, stronger, cart_limits=limits, relax=np.inf).plan((-110, 0, 0))
        planner.plan((-110, 0, 0), estimate=known[-1])
        again = planner.plan((-110, 0, 0), estimate=known[-1], arms=stronger)
        assert again.effort == pytest.approx(fresh.effort, rel=1e-8)
        rows = planner._now.terms.base.cart_rows
        assert planner.plan((-110, 0, 0), estimate=known[-1]).effort == pytest.approx(fresh.effort, rel=1e-8)
        assert planner._now.terms.base.cart_rows is rows
    assert planner.plan((-110, 0, 0), estimate=known[1]).effort != pytest.approx(fresh.effort, rel=1e-3)


def test_an_estimate_that_is_no_cart_is_refused():
    planner = WrenchPlanner(shopping_cart(), pair(), cart_limits=[Skid(0.5)])
    wrong = cg.Estimate(1.0, Motion(np.zeros(3), np.zeros(2)), {}, "", shopping_cart(), np.array([-1.0, 0, 0, 1]))
    plan = planner.plan((40, 0, 3), estimate=wrong)
    assert plan.status == "invalid_input"
    assert plan.message.startswith("estimate: mass")
    assert planner.plan((40, 0, 3)).status == "optimal"


@pytest.mark.parametrize("objective", [LeastSideForce(2.0), None])
def test_an_estimate_that_is_refused_is_not_believed(objective):
    """Also where only a cost looks at it, or nothing but what plans tell of the wheels: the next plan is by the
    estimate before. Where nothing did, `wheel_side_force` had raised."""
    planner = WrenchPlanner(shopping_cart(), pair(), objective=objective)
    before = planner.plan((40, 0, 3))
    casters = cg.CartModel(shopping_cart().inertia, RollingConstraints(None))
    wrong = cg.Estimate(1.0, Motion(np.zeros(3), np.zeros(3)), {}, "", casters, casters.parameters)
    plan = planner.plan((40, 0, 3), estimate=wrong)
    assert plan.status == "invalid_input"
    assert "other rolling constraints" in plan.message
    assert planner.plan((40, 0, 3)).wheel_side_force == pytest.approx(before.wheel_side_force)


# --- what would do ------------------------------------------------------------------------------------------


def test_the_planners_own_contacts_are_proposed():
    planner = WrenchPlanner(cart(), [bar("hand")])
    plan = planner.plan((40, 0, 14), contacts={"hand": (-0.25, 0.1, 1.0)})
    assert plan.status == "infeasible"
    (contact,) = plan.certificate.remedy.values()
    assert plan.certificate.words.endswith(f"with hand at y = {contact[1]:.3g} m it would be feasible")
    assert planner.plan((40, 0, 14), contacts=plan.certificate.remedy).status == "optimal"
    assert "remedy" in json.loads(json.dumps(plan.as_dict(), allow_nan=False))["certificate"]


def test_a_hand_moved_aside_is_proposed_and_would_do():
    plan = WrenchPlanner(cart(), [arm("left")]).plan((40, 0, 13))
    assert plan.status == "infeasible"
    assert "tz upper" in plan.message
    moved = [arm("left", list(plan.certificate.remedy.values()))]
    assert WrenchPlanner(cart(), moved).plan((40, 0, 13)).status == "optimal"
    kept = WrenchPlanner(cart(), [arm("left", reach=cg.Reach.box((-1, 0.1, 0), (1, 1, 2)))]).plan((40, 0, 13))
    assert kept.certificate.remedy == {}


def test_nothing_is_proposed_where_nothing_would_do():
    plan = WrenchPlanner(cart(), pair()).plan((150, 0, 0))
    assert plan.certificate.remedy == {}
    assert "would be feasible" not in plan.message


@pytest.mark.parametrize("seed", range(6))
def test_handles_know_the_rate_too(seed):
    """A rate may leave no wrench for which one end of a handle is that of more moment: such cases are proven empty."""
    rng = np.random.default_rng(seed)
    rate = (3e3,) * 3 + (3e2,) * 3
    arms = [bar("left", friction=None, wrench_rate=rate), bar("right", friction=None, wrench_rate=rate)]
    first, second = rng.uniform((20, 0, -2), (50, 0, 2)), rng.uniform((20, 0, -8), (50, 0, 8))
    held = {"left": (-0.25, 0.2, 1.0), "right": (-0.25, -0.2, 1.0)}

    def after_first():
        planner = WrenchPlanner(cart(), arms, period=1e-2)
        assert planner.plan(first, contacts=held).status == "optimal"
        return planner

    best = np.inf
    for one in np.linspace(-0.25, 0.25, 9):
        for other in np.linspace(-0.25, 0.25, 9):
            points = {"left": (-0.25, one, 1.0), "right": (-0.25, other, 1.0)}
            plan = after_first().plan_or_hold(second, contacts=points)
            best = min(best, plan.effort) if plan.status == "optimal" else best
    plan = after_first().plan_or_hold(second)
    assert plan.status in ("optimal", "infeasible")
    if np.isfinite(best):
        assert plan.status == "optimal"
        assert plan.effort <= best * (1 + 1e-9)
        assert plan.choice.gap <= 1e-9
