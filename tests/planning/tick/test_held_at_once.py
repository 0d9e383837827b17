"""A wrench that can't be given is held at once after `warm_up`; why, the plan finds when asked, as it was then."""

from __future__ import annotations

import numpy as np
import pytest

from cartgrasp.arms import Arm
from cartgrasp.errors import UsageError
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from planning import WrenchPlanner
from planning.plan import Plan
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


@pytest.mark.parametrize("places", [ONE, TWO])
def test_it_is_explained_as_the_general_road_does_whatever_came_after(places):
    warm, cold = planners(places)
    expected, plan = cold.plan_or_hold(BEYOND), warm.plan_or_hold(BEYOND)
    warm.plan((10.0, 0.0, 0.0), arms=[Arm("right", [(-0.3, -0.3, 0.9)], force_limit=(5.0, 5.0, 5.0))])
    assert plan.certificate is not None
    assert plan.certificate.verified
    assert plan.message == plan.certificate.words == expected.message
    np.testing.assert_allclose(plan.nearest.wrench, expected.nearest.wrench, rtol=1e-6, atol=1e-9)
    told, other = plan.as_dict(), expected.as_dict()
    assert told.keys() == other.keys()
    assert told["certificate"]["limits"] == other["certificate"]["limits"]
    assert (told["choice"] is None) == (other["choice"] is None)


def test_nothing_else_is_left_open():
    plan = Plan("timeout", message="too late")
    assert (plan.certificate, plan.message, plan.held) == (None, "too late", None)
    with pytest.raises(AttributeError, match="no attribute 'wrench'"):
        plan.wrench  # noqa: B018
    with pytest.raises(UsageError, match="too late"):
        plan.contact_wrenches  # noqa: B018
