"""WrenchPlanner: what it answers, what it refuses, and that it is always safe."""

from __future__ import annotations

import json
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.errors import UsageError
from planning import Smoothness, WrenchPlanner, allocate, build_allocation

from .drawn import arm, bar, cart, first_contacts, random_arms, random_cart, violation


def pair():
    return [arm("left", [(-0.25, 0.2, 1.0)]), arm("right", [(-0.25, -0.2, 1.0)])]


def touched(model, arms, contacts, wrench, plan):
    """Names of the limits that a plan's wrenches reach."""
    program = build_allocation(model, arms, contacts, wrench)
    x = np.concatenate(list(plan.wrenches.values()))
    values = np.concatenate([x, program.rows @ x])
    names = [program.upper_names[i] for i in np.flatnonzero(program.upper - values < 1e-7)]
    return {*names, *(program.lower_names[i] for i in np.flatnonzero(values - program.lower < 1e-7))}


@pytest.mark.parametrize("seed", range(20))
def test_the_fast_path_equals_a_fresh_allocation(seed):
    rng = np.random.default_rng(seed)
    model, arms = random_cart(rng), random_arms(rng, int(rng.integers(1, 5)))
    planner = WrenchPlanner(model, arms)
    planner.warm_up()
    for _ in range(10):
        wrench = rng.uniform((-5, -20, -12), (80, 20, 12))
        contacts = {a.name: rng.uniform(-0.5, 0.5, 3) for a in arms} if rng.random() < 0.3 else None
        plan = planner.plan(wrench, contacts=contacts)
        found = allocate(model, arms, contacts or first_contacts(arms), wrench)
        assert plan.status == found.status
        if plan.status == "optimal":
            assert plan.effort == pytest.approx(found.effort, rel=1e-9, abs=1e-12)
            assert touched(model, arms, contacts or first_contacts(arms), wrench, plan) >= set(plan.active)
            assert plan.residuals.equality <= 1e-9 * max(1, np.abs(wrench).max())
            assert plan.choice.solved == 1
            assert plan.solver == "dual active set"  # a fallback would hide a stale workspace
            assert plan.message == ""


def test_a_plan_as_json():
    plan = WrenchPlanner(cart(), pair()).plan((40, 0, 3))
    document = json.loads(json.dumps(plan.as_dict(), allow_nan=False))
    assert list(document) == [
        "status",
        "effort",
        "arms",
        "active",
        "residuals",
        "choice",
        "certificate",
        "solve_time_s",
        "margins",
        "cart_wrench",
        "wheel_side_force",
    ]
    assert document["margins"] == dict(plan.margins)
    assert document["status"] == "optimal"
    assert document["arms"]["left"]["contact"] == [-0.25, 0.2, 1.0]
    assert len(document["arms"]["right"]["wrench"]) == 6
    assert set(document["residuals"]) == {"equality", "limits", "stationarity", "gap"}
    assert set(document["choice"]) == {"bound", "gap", "solved"}
    assert document["certificate"] is None
    assert 0 < document["solve_time_s"] < 10


def test_an_infeasible_plan_as_json():
    for planner in (WrenchPlanner(cart(), pair()), WrenchPlanner(cart(), [bar("left"), bar("right")])):
        plan = planner.plan((150, 0, 0))
        document = json.loads(json.dumps(plan.as_dict(), allow_nan=False))
        assert document["status"] == "infeasible"
        assert document["effort"] is None
        assert document["arms"] == {}
        assert document["certificate"]["limits"] == {"left: fx upper": 60.0, "right: fx upper": 60.0}
        assert document["certificate"]["most"] == pytest.approx(120)
        nearest = document["nearest"]
        assert nearest["wrench"] == pytest.approx([120, 0, 0], abs=1e-8)
        assert nearest["distance"] == pytest.approx(30)
        assert nearest["effort"] == pytest.approx(7200)
        assert set(nearest["arms"]["left"]) == {"contact", "wrench"}
    far = WrenchPlanner(cart(), [bar("left"), bar("right")], min_hand_distance=0.7).plan((1, 0, 0))
    assert json.loads(json.dumps(far.as_dict(), allow_nan=False))["nearest"] is None


BAD_WRENCHES = [
    ((np.nan, 0, 0), "nan"),
    ((0, np.inf, 0), "inf"),
    ((1e200, 0, 0), "beyond"),
    ((1, 2), "shape"),
    (np.zeros((3, 1)), "shape"),
    ("abc", "abc"),
    (None, "shape"),
    ((None, 0, 0), "nan"),
    ((1, [2], 3), "three numbers"),
    ((10**400, 0, 0), "three numbers"),
    ((1j, 0, 0), "three numbers"),
]


@pytest.mark.parametrize(("wrench", "why"), BAD_WRENCHES)
def test_a_bad_wrench_is_refused_before_the_solve(wrench, why):
    planner = WrenchPlanner(cart(), pair())
    plan = planner.plan(wrench)
    assert plan.status == "invalid_input"
    assert plan.message.startswith("wrench: ")
    assert why in plan.message
    assert plan.wrenches == {}
    assert plan.effort is None
    assert json.dumps(plan.as_dict(), allow_nan=False)
    held = planner.plan_or_hold(wrench)
    assert all((w == 0).all() for w in held.contact_wrenches.wrenches.values())


@pytest.mark.parametrize(
    ("contacts", "why"),
    [
        ({"middle": (0, 0, 0)}, "no arm 'middle'"),
        ({"left": (0, np.nan, 0)}, "contacts: left"),
        ({"left": (0, 0)}, "shape"),
        ({"left": None}, "contacts: left"),
        ([(0, 0, 0)], "mapping"),
    ],
)
def test_bad_contacts_are_refused(contacts, why):
    plan = WrenchPlanner(cart(), pair()).plan((40, 0, 3), contacts=contacts)
    assert plan.status == "invalid_input"
    assert why in plan.message


def estimate(time, value=20.0, velocity=0.0):
    motion = SimpleNamespace(pose_sb=np.zeros(3), velocity=np.array([velocity, 0.0]))
    of_cart = {"structure": cart(), "model_parameters": cart().parameters}
    return SimpleNamespace(time=time, motion=motion, parameters={"mass": SimpleNamespace(value=value)}, **of_cart)


def test_estimates_are_checked():
    planner = WrenchPlanner(cart(), pair())
    assert planner.plan((40, 0, 3), estimate=estimate(10.0)).status == "optimal"
    assert planner.plan((40, 0, 3), estimate=estimate(9.9)).status == "optimal"
    stale = planner.plan((40, 0, 3), estimate=estimate(9.0))
    assert stale.status == "stale_estimate"
    assert "1 s older" in stale.message
    for bad in (estimate(np.nan), estimate(11.0, value=np.nan), estimate(11.0, velocity=np.inf)):
        assert planner.plan((40, 0, 3), estimate=bad).status == "invalid_input"


def test_some_contacts_given_and_some_chosen():
    planner = WrenchPlanner(cart(), [bar("left"), bar("right")], min_hand_distance=0.1)
    plan = planner.plan((40, 0, 4), contacts={"left": (-0.25, -0.1, 1.0)})
    assert plan.status == "optimal"
    assert plan.contacts["left"] == pytest.approx([-0.25, -0.1, 1.0])
    assert abs(plan.contacts["right"][1] + 0.1) >= 0.1 - 1e-9
    both = planner.plan((40, 0, 4), contacts={"left": (-0.25, -0.1, 1), "right": (-0.25, -0.05, 1)})
    assert both.status == "infeasible"
    assert "0.1 m apart" in both.certificate.words


def test_contacts_of_another_tick_are_not_kept():
    """What was given or chosen before may not be allowed now, however good it is."""
    planner = WrenchPlanner(cart(), [bar("left"), bar("right")])
    far = {"left": (-0.25, -0.6, 1.0), "right": (-0.25, -0.5, 1.0)}
    assert planner.plan((40, 0, 22), contacts=far).status == "optimal"
    chosen = planner.plan((40, 0, 22))
    assert chosen.status == "optimal"
    assert all(abs(point[1]) <= 0.25 for point in chosen.contacts.values())
    narrowed = planner.plan((40, 0, 22), contacts={"left": (-0.25, 0.2, 1.0)})
    assert narrowed.contacts["left"] == pytest.approx([-0.25, 0.2, 1.0])
    assert narrowed.effort > chosen.effort


def test_results_can_not_be_written_to():
    plan = WrenchPlanner(cart(), pair()).plan((40, 0, 3))
    with pytest.raises(ValueError, match="read-only"):
        plan.wrenches["left"][0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        plan.contacts["left"][0] = 1.0


def test_contact_wrenches_of_a_plan_without_one():
    plan = WrenchPlanner(cart(), pair()).plan((150, 0, 0))
    with pytest.raises(UsageError, match="plan_or_hold"):
        _ = plan.contact_wrenches


def test_contact_wrenches_give_the_wrench():
    arms = [arm("left", yaw=0.5), arm("right", [(-0.25, -0.2, 1.0)], yaw=-0.3)]
    plan = WrenchPlanner(cart(0), arms).plan((40, 2, 3))
    assert plan.contact_wrenches.wrench_b == pytest.approx([40, 2, 3], abs=1e-9)


def test_holding_decays_with_the_stated_time_constant():
    planner = WrenchPlanner(cart(), pair(), period=1e-3)
    good = planner.plan_or_hold((40, 0, 3)).contact_wrenches.wrenches["left"]
    for _ in range(100):
        plan = planner.plan_or_hold((150, 0, 0))
        assert plan.status == "infeasible"
    assert plan.contact_wrenches.wrenches["left"] == pytest.approx(good * np.exp(-1), rel=1e-9)
    assert plan.contact_wrenches.contacts["left"] == pytest.approx([-0.25, 0.2, 1.0])
    again = planner.plan_or_hold((40, 0, 3))
    assert again.status == "optimal"
    assert again.contact_wrenches.wrenches["left"] == pytest.approx(good)


anything = st.floats(allow_nan=True, allow_infinity=True)


@settings(max_examples=150)
@given(st.lists(st.tuples(anything, anything, anything), min_size=1, max_size=6))
def test_plan_or_hold_is_safe_whatever_comes(wrenches):
    arms = pair()
    planner = WrenchPlanner(cart(), arms)
    planner.plan_or_hold((40, 0, 3))
    for wrench in wrenches:
        given_back = planner.plan_or_hold(wrench).contact_wrenches
        assert set(given_back.wrenches) == {"left", "right"}
        assert np.isfinite(np.concatenate(list(given_back.wrenches.values()))).all()
        assert violation(arms, given_back.wrenches) <= 1e-6


def test_smoothness_looks_back_at_what_was_held():
    planner = WrenchPlanner(cart(), pair(), objective=Smoothness(1e6))
    contacts = {"left": (-0.25, 0.2, 1.0), "right": (-0.25, -0.2, 1.0)}
    first = planner.plan((40, 0, 5), contacts)
    second = planner.plan((40, 0, 5), contacts)
    moved = np.abs(second.wrenches["left"] - first.wrenches["left"]).max()
    assert moved <= 1e-3
    assert second.solver == "daqp"
    planner.reset()
    assert planner.plan((40, 0, 5), contacts).wrenches["left"] == pytest.approx(first.wrenches["left"])


def test_warm_up_leaves_no_trace():
    rested, fresh = (WrenchPlanner(cart(), pair(), objective=Smoothness(5.0)) for _ in range(2))
    rested.warm_up()
    one, other = rested.plan((40, 0, 3)), fresh.plan((40, 0, 3))
    assert one.wrenches["left"] == pytest.approx(other.wrenches["left"], abs=1e-12)


def test_what_is_a_programming_error():
    with pytest.raises(UsageError, match="none given"):
        WrenchPlanner(cart(), [])
    with pytest.raises(UsageError, match="stands twice"):
        WrenchPlanner(cart(), [arm("left"), arm("left")])
    with pytest.raises(UsageError, match="min_hand_distance"):
        WrenchPlanner(cart(), pair(), min_hand_distance=np.nan)
    with pytest.raises(UsageError, match="period"):
        WrenchPlanner(cart(), pair(), period=0.0)


def test_importing_planning_loads_no_slow_solver():
    code = (
        "import sys, planning; "
        "print(sorted(m for m in ('clarabel', 'cvxpy', 'scipy.sparse', 'scipy.optimize', 'pydantic') "
        "if m in sys.modules and m not in before))"
    )
    code = "import sys, cartgrasp; before = set(sys.modules); " + code
    printed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert printed.strip() == "[]"
