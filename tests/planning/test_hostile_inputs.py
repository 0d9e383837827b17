"""What is no number, no arm, no contact or no estimate is refused in a sentence, before and after `warm_up`, and
leaves the planner as it was."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import cartgrasp as cg
from cartgrasp.effects import WheelMisalignment
from cartgrasp.joint_torques import JointTorques
from cartgrasp.motion import Motion
from planning import (
    InternalForce,
    LeastJointTorque,
    Lexicographic,
    Nothing,
    Skid,
    TipOver,
    WeightedWrench,
    WorstArm,
    WrenchPlanner,
    allocate,
)

from .contacts.test_contact_choice_with_cart_limits import joints, shopping_cart
from .drawn import arm, cart, first_contacts

REST = Motion(np.zeros(3), np.zeros(2))
COVARIANCE = np.diag([1.0, 0.1, 0.1, 0.5]) ** 2


def pair(**changes):
    return [arm("left", [(-0.25, 0.2, 1.0)], **changes), arm("right", [(-0.25, -0.2, 1.0)])]


@pytest.fixture(params=[False, True], ids=["cold", "warm"])
def made(request):
    """Makes planners."""

    def make(model=None, arms=None, **options):
        planner = WrenchPlanner(model or cart(), arms or pair(), **options)
        if request.param:
            planner.warm_up()
        return planner

    return make


# --- wrenches, contacts, starts -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "wrench",
    [
        ["40", "0", "3"],
        np.array([40, 0, 3j]),
        np.array(["2020", "2021", "2022"], dtype="datetime64[Y]"),
        np.array([None, 0, 0]),
        (x for x in (40, 0, 3)),
    ],
)
def test_what_is_no_wrench(made, wrench):
    planner = made()
    for plan in (planner.plan(wrench), planner.plan_or_hold(wrench)):
        assert plan.status == "invalid_input"
        assert plan.message.startswith("wrench: ")


def test_a_wrench_of_any_real_kind(made):
    planner = made()
    wide = np.array([40, 9, 0, 9, 3, 9], dtype=np.float32)
    kinds = [wide[::2], np.array([40, 0, 3], dtype=object), [np.int8(40), 0, np.float16(3)], range(3)]
    assert [planner.plan(wrench).status for wrench in kinds] == ["optimal"] * 4


@pytest.mark.parametrize(
    "contacts",
    [
        np.zeros((2, 3)),
        {"left": np.array([0, 0, 1j]), "right": (0, 0, 1)},
        {"left": ("0", "0", "1"), "right": (0, 0, 1)},
        {"left": (0, 0, np.inf), "right": (0, 0, 1)},
        {"left": (0, 2e6, 0), "right": (0, 0, 1)},
        {"left": (0, 0, 0), "right": (0, 0, 1), 3: (0, 0, 0)},
        "left",
    ],
)
def test_what_are_no_contacts(made, contacts):
    planner = made(arms=pair(reach=cg.Reach.box((-1, -1, 0), (1, 1, 2))))
    plan = planner.plan((40, 0, 3), contacts)
    assert plan.status == "invalid_input"
    assert plan.message.startswith("contacts: ")


def test_an_arm_that_is_not_there_among_contacts_that_are_known(made):
    planner, contacts = made(), first_contacts(pair())
    assert planner.plan((40, 0, 3), contacts).status == "optimal"
    assert planner.plan((40, 0, 3), contacts | {"nobody": (0, 0, 0)}).status == "invalid_input"


def test_a_remedy_is_sought_within_the_largest_position(made):
    planner = made()
    for y in (50.0, -50.0):
        assert planner.plan((500, 0, 3), {"left": (-0.25, y, 1.0)}).status == "infeasible"


@pytest.mark.parametrize(
    "start",
    [{"left": (1, 2)}, {"left": "abc"}, {"left": np.ones(6) * 1j}, {"left": 3.0}, [1, 2], None, {3: np.ones(6)}],
)
def test_what_is_no_start(made, start):
    with pytest.raises(cg.UsageError, match=r"start_from: .* of left, right"):
        made().start_from(start)


# --- arms ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("arms", [[None], "left", 7, ["left"], {"left": arm("left")}, [arm("left"), arm("left")]])
def test_what_are_no_arms(made, arms):
    planner = made()
    before = planner.plan((40, 0, 3))
    plan = planner.plan((40, 0, 3), arms=arms)
    assert plan.status == "invalid_input"
    assert plan.message.startswith("arms: ")
    assert planner.plan((40, 0, 3)).effort == pytest.approx(before.effort)


def test_arms_that_the_objective_has_no_use_for(made):
    strong = JointTorques(np.eye(6), np.zeros(6), np.full(6, 90.0))
    endless = arm("left", force_limit=(np.inf,) * 3, moment_limit=(np.inf,) * 3)
    for objective, first, new in (
        (LeastJointTorque(), arm("left", joints=strong), arm("left")),
        (Lexicographic(WorstArm(1.0, Nothing()), LeastJointTorque()), arm("left", joints=strong), arm("left")),
        (WorstArm(1.0), arm("left"), endless),
    ):
        planner = made(arms=[first], objective=objective)
        before = planner.plan((40, 0, 3))
        refused = planner.plan_or_hold((40, 0, 3), arms=[new])
        assert refused.status == "invalid_input"
        assert "none of ['left']" in refused.message
        assert planner.plan((40, 0, 3)).effort == pytest.approx(before.effort)


def test_objectives_that_can_not_be_are_refused_at_once():
    with pytest.raises(cg.UsageError, match="states its joints"):
        WrenchPlanner(cart(), pair(), objective=Lexicographic(WorstArm(1.0, Nothing()), LeastJointTorque()))
    order = Lexicographic(WeightedWrench(), WorstArm(1.0))
    with pytest.raises(cg.UsageError, match="put it first"):
        WrenchPlanner(cart(), pair(), objective=order)
    with pytest.raises(cg.UsageError, match="put it first"):
        allocate(cart(), pair(), first_contacts(pair()), (40, 0, 3), order)


def test_new_arms_at_the_edge_of_friction_keep_the_last_wrench(made):
    """By rounding the last wrench is a hair beyond the edge: that scales nothing, and the rate holds from there on."""
    rate = {"wrench_rate": (500.0,) * 6, "moment_limit": (0, 0, 0)}
    rng = np.random.default_rng(0)
    for _ in range(20):
        arms = [arm("hand", [(-0.25, 0.1, 1.0)], yaw=rng.uniform(-1, 1), friction=cg.Friction(0.4, 8), **rate)]
        planner = made(cart(0), arms, period=1e-2, relax=np.inf)
        planner.start_from({"hand": (30, 0, 0, 0, 0, 0)})
        for _ in range(5):
            planner.plan_or_hold(rng.uniform((0, -60, 0), (40, 60, 0)))
        last = planner.plan_or_hold((20, 40, 0)).contact_wrenches.wrenches["hand"]
        new = arm("hand", [(-0.25, 0.1, 1.0)], yaw=arms[0].yaw, friction=cg.Friction(0.4, 8), **rate)
        held = planner.plan_or_hold((np.nan, 0, 0), arms=[new]).contact_wrenches.wrenches["hand"]
        assert np.abs(held - last).max() <= 5.0 * (1 + 1e-9)


def test_rates_beyond_what_floats_hold(made):
    for rate, period in ((1e-300, 1e-300), (1e10, 0.5)):
        planner = made(arms=pair(wrench_rate=(rate,) * 6), period=period)
        assert planner.plan((40, 0, 3)).status == "optimal"
        assert planner.plan_or_hold((np.nan, 0, 0)).status == "invalid_input"


def test_weights_beyond_what_floats_hold(made):
    assert made(arms=[arm("left", weights=(5e-324,) * 6)]).plan((4, 0, 0.3)).status == "optimal"


@pytest.mark.parametrize("axis", [(1e300, 1e300, 0), (5e-324, 0, 0)])
def test_an_axis_of_any_length(made, axis):
    assert made(cart_limits=[InternalForce(5.0, axis)]).plan((40, 0, 3)).status == "optimal"


def test_names_of_any_kind(made):
    """A name says nothing of a limit's unit."""
    for name in ("force arm", "fx", "左手 😀", "x" * 10_000):
        plan = made(arms=[arm(name)]).plan((40, 0, 14))
        assert plan.status == "infeasible"
        assert f"{name}: tz upper 6 N·m;" in plan.message


@pytest.mark.parametrize("seed", range(10))
def test_the_largest_wrench_is_certified(seed):
    rng = np.random.default_rng(seed)
    arms = pair(friction=None, joints=joints(rng))
    planner = WrenchPlanner(shopping_cart(), arms, cart_limits=[TipOver(5.0), Skid(0.5)])
    plan = planner.plan_or_hold(rng.uniform(-1e6, 1e6, 3))
    assert plan.status == "infeasible"
    assert plan.certificate.direction
    assert planner.plan((1.1e6, 0, 0)).status == "invalid_input"


# --- estimates ----------------------------------------------------------------------------------------------


def estimate(model=None, **changes):
    model = model or shopping_cart()
    stated = {"time": 0.0, "motion": REST, "parameters": {}, "health": "", "structure": model}
    stated |= {"model_parameters": model.parameters, "covariance": COVARIANCE}
    return cg.Estimate(**(stated | changes))


PHI = shopping_cart().parameters
OTHER = cg.CartModel(shopping_cart().inertia, cg.RollingConstraints(0.3))
STRAIGHT = shopping_cart().with_effect(WheelMisalignment())
WRONG = [
    (estimate(time=None), "not those of an Estimate"),
    (estimate(time="1"), "not those of an Estimate"),
    (estimate(time=1j), "not those of an Estimate"),
    (estimate(motion=None), "not those of an Estimate"),
    (estimate(parameters=None), "not those of an Estimate"),
    (estimate(parameters={"mass": 1.0}), "not those of an Estimate"),
    (estimate(parameters={"mass": SimpleNamespace(value=None)}), "not those of an Estimate"),
    ("abc", "not those of an Estimate"),
    ({}, "not those of an Estimate"),
    (estimate(motion=Motion(np.zeros(3), np.zeros(1))), "velocity (2,)"),
    (estimate(motion=Motion(np.zeros(3), np.zeros((2, 2)))), "velocity (2,)"),
    (estimate(motion=Motion(1.0, np.zeros(2))), "pose_sb (3,)"),
    (estimate(motion=Motion(np.zeros(3), np.full(2, 1e200))), "can't be true"),
    (estimate(motion=Motion(np.zeros(3), np.full(2, 1e8))), "can't be true"),
    (estimate(model_parameters=None), "the 4 numbers"),
    (estimate(model_parameters=PHI[:3]), "the 4 numbers"),
    (estimate(model_parameters=PHI[None]), "the 4 numbers"),
    (estimate(model_parameters=PHI + 0j), "the 4 numbers"),
    (estimate(model_parameters=PHI * [-1, 1, 1, 1]), "mass: -24 kg"),
    (estimate(model_parameters=PHI * 1e300), "not finite"),
    (estimate(model_parameters=np.array([1e-320, 0, 0, 1e-320])), "estimate"),
    (estimate(structure=None), "it has no cart"),
    (estimate(structure=OTHER), "other rolling constraints"),
    (estimate(structure=STRAIGHT, model_parameters=np.append(PHI, 0.1)), "other rolling constraints"),
]
WRONG_COVARIANCES = [
    ([[1], [2, 3]], "not a matrix"),
    ("abc", "not a matrix"),
    (COVARIANCE + 1j, "not a matrix"),
    (1e16 * COVARIANCE, "can't be true"),
    (1e300 * COVARIANCE, "can't be true"),
]


@pytest.mark.parametrize(("wrong", "why"), WRONG)
@pytest.mark.parametrize("confidence", [None, 0.99])
def test_what_is_no_estimate(made, wrong, why, confidence):
    planner = made(shopping_cart(), pair(), cart_limits=[Skid(0.5), TipOver(1.0)], confidence=confidence)
    before = planner.plan((40, 0, 3))
    plan = planner.plan_or_hold((40, 0, 3), estimate=wrong)
    assert plan.status == "invalid_input"
    assert plan.message.startswith("estimate: ")
    assert why in plan.message
    assert planner.plan((40, 0, 3)).effort == pytest.approx(before.effort)


@pytest.mark.parametrize(("wrong", "why"), WRONG_COVARIANCES)
def test_what_is_no_covariance(made, wrong, why):
    planner = made(shopping_cart(), pair(), cart_limits=[Skid(0.5), TipOver(1.0)], confidence=0.99)
    plan = planner.plan_or_hold((40, 0, 3), estimate=estimate(covariance=wrong))
    assert plan.status == "invalid_input"
    assert why in plan.message
    as_lists = estimate(covariance=COVARIANCE.tolist(), model_parameters=PHI.tolist())
    assert planner.plan((40, 0, 3), estimate=as_lists).status == "optimal"


def test_an_estimate_that_is_refused_makes_no_other_stale(made):
    planner = made(shopping_cart(), pair(), cart_limits=[Skid(0.5)])
    assert planner.plan((40, 0, 3), estimate=estimate(time=9.0, model_parameters=-PHI)).status == "invalid_input"
    assert planner.plan((40, 0, 3), estimate=estimate(time=1.0)).status == "optimal"
    stale = planner.plan((40, 0, 3), estimate=estimate(time=0.3))
    assert stale.status == "stale_estimate"
    assert "0.7 s older than the newest one given before; 0.5 s is allowed; reset() forgets that one" in stale.message
