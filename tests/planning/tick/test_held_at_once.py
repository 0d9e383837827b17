"""A wrench that can't be given is held at once after `warm_up`; why, the plan finds when asked, as it was then."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.arms import Arm, Friction
from cartgrasp.errors import UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from planning import WrenchPlanner
from planning.plan import RELAXED, Plan
from planning.quadratic_program import INFEASIBLE

BEYOND = (500.0, 0.0, 10.0)
CART = CartModel(Inertia(24.0, (0.3, 0.0), 2.0))


def arms(*places):
    limits = {"force_limit": (60.0, 60.0, 40.0), "moment_limit": (8.0, 8.0, 6.0)}
    return [Arm("left", list(places), **limits), Arm("right", [(-0.25, -0.2, 1.0)], **limits)]


ONE, TWO = arms((-0.25, 0.2, 1.0)), arms((-0.25, 0.2, 1.0), (-0.25, 0.1, 1.0))


def planners(places):
    """A warm one, and one that knows the general road alone; both have planned the same."""
    warm, cold = WrenchPlanner(CART, places), WrenchPlanner(CART, places)
    warm.warm_up()
    for planner in (warm, cold):
        assert planner.plan((30.0, 0.0, 1.0)).is_usable
    return warm, cold


@pytest.mark.parametrize("places", [ONE, TWO])
def test_no_general_solver_is_asked_at_the_tick(places, monkeypatch):
    warm, cold = planners(places)
    expected = cold.plan_or_hold(BEYOND)
    with monkeypatch.context() as patched:
        patched.setattr("planning.solvers.QuadraticSolver.solve", None)
        patched.setattr("planning.contacts.contact_choice.ContactSearch.run", None)
        plan = warm.plan_or_hold(BEYOND)
        held = plan.contact_wrenches
        assert plan.status == INFEASIBLE
        assert not plan.is_usable
    for name, wrench in expected.contact_wrenches.wrenches.items():
        np.testing.assert_allclose(held.wrenches[name], wrench, rtol=1e-9)
    assert any(np.abs(wrench).max() > 1.0 for wrench in held.wrenches.values())


def test_what_is_relaxed_is_not_explained_at_the_tick_either(monkeypatch):
    """Also where switching has a cost: which arms it moved is told at once."""
    planner = WrenchPlanner(CART, TWO, relax=np.inf, switching_cost=5.0)
    planner.warm_up()
    first, second = ({"left": point, "right": (-0.25, -0.2, 1.0)} for point in TWO[0].contacts.points)
    planner.plan_or_hold((30.0, 0.0, 1.0), first)
    with monkeypatch.context() as patched:
        patched.setattr(Plan, "explain", None)
        plan = planner.plan_or_hold(BEYOND, second)
        assert (plan.status, plan.switched) == (RELAXED, ("left",))
    assert plan.certificate.verified
    assert plan.message == plan.certificate.words


def test_the_nearest_is_the_nearest_where_it_takes_forces_a_thousand_times_as_large():
    """A hand whose friction all but lets it turn the cart by its force alone."""
    hand = Arm(
        "hand",
        [(-0.29346, -0.30964, 1.0)],
        yaw=1.870469,
        friction=Friction(0.309292),
        force_limit=(12e3, 10e3, 2e3),
        moment_limit=(400.0, 360.0, 675.6),
    )
    asked = np.array([1.0374, 0.0, -0.41977])
    warm, cold = (WrenchPlanner(CART, [hand], relax=np.inf) for _ in range(2))
    warm.warm_up()
    plans = [planner.plan_or_hold(asked) for planner in (warm, cold)]
    missed = [np.linalg.norm((plan.cart_wrench - asked)[[0, 2]]) for plan in plans]
    assert missed[0] == pytest.approx(missed[1], rel=1e-4)
    assert np.linalg.norm(list(plans[0].missing.values())) == pytest.approx(missed[0], rel=1e-4)


@pytest.mark.parametrize("places", [ONE, TWO])
def test_it_is_explained_as_the_general_road_does_whatever_came_after(places):
    warm, cold = planners(places)
    expected, plan = cold.plan_or_hold(BEYOND), warm.plan_or_hold(BEYOND)
    warm.plan((10.0, 0.0, 0.0), arms=[Arm("right", [(-0.3, -0.3, 0.9)], force_limit=(5.0, 5.0, 5.0))])
    assert plan.certificate is not None
    assert plan.explain().certificate is plan.certificate
    assert plan.certificate.verified
    assert expected.explain() is expected
    assert plan.message == plan.certificate.words == expected.message
    np.testing.assert_allclose(plan.nearest.wrench, expected.nearest.wrench, rtol=1e-6, atol=1e-9)
    told, other = plan.as_dict(), expected.as_dict()
    assert told.keys() == other.keys()
    assert told["certificate"]["limits"] == other["certificate"]["limits"]
    assert (told["choice"] is None) == (other["choice"] is None)


WAYS = st.tuples(st.floats(-400, 400), st.floats(-5, 5), st.floats(-80, 80))


@pytest.fixture(scope="module")
def relaxing():
    """A warm planner that relaxes, and one that knows the general road alone."""
    warm, cold = (WrenchPlanner(CART, ONE, relax=np.inf) for _ in range(2))
    warm.warm_up()
    return warm, cold


@given(wrench=WAYS)
def test_the_nearest_is_given_at_once(relaxing, wrench):
    """As the general road does: by the same status, what is missing and what it costs."""
    plan, expected = (planner.plan_or_hold(wrench) for planner in relaxing)
    assert plan.status == expected.status
    scale = max(1.0, *map(abs, wrench))
    assert plan.effort == pytest.approx(expected.effort, rel=1e-5, abs=1e-6)
    np.testing.assert_allclose(plan.cart_wrench[[0, 2]], expected.cart_wrench[[0, 2]], atol=1e-6 * scale)
    if plan.status == RELAXED:
        assert plan.message == plan.certificate.words == expected.message
        assert plan.certificate.verified
        assert plan.missing == pytest.approx(expected.missing, rel=1e-6, abs=1e-8)
        for name, wrench_a in plan.wrenches.items():
            limit = next(arm for arm in ONE if arm.name == name).wrench_limit
            assert (np.abs(wrench_a) <= limit + 1e-9 * scale).all()


def test_no_general_solver_is_asked_for_the_nearest(relaxing, monkeypatch):
    warm, _ = relaxing
    with monkeypatch.context() as patched:
        patched.setattr("planning.solvers.QuadraticSolver.solve", None)
        plan = warm.plan_or_hold(BEYOND)
        assert plan.status == RELAXED
        assert np.linalg.norm(np.subtract(BEYOND, plan.cart_wrench)[[0, 2]]) > 100.0
    assert plan.proof[1].status == "optimal"


@pytest.mark.parametrize("relax", [1.0, 500.0])
def test_what_is_too_far_is_held(relax):
    warm = WrenchPlanner(CART, ONE, relax=relax)
    warm.warm_up()
    plan = warm.plan_or_hold(BEYOND)
    assert plan.status == (RELAXED if relax > 400.0 else INFEASIBLE)
    assert plan.certificate.nearest.distance == pytest.approx(380.0, rel=0.1)


def test_nothing_else_is_left_open():
    plan = Plan("timeout", message="too late")
    assert (plan.certificate, plan.message, plan.held) == (None, "too late", None)
    with pytest.raises(AttributeError, match="no attribute 'wrench'"):
        plan.wrench  # noqa: B018
    with pytest.raises(UsageError, match="too late"):
        plan.contact_wrenches  # noqa: B018
