"""The convex relaxation of contact choice: a closed form, and a bound below every exact choice."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cartgrasp.arms import Arm, Friction
from cartgrasp.inertia import Inertia
from cartgrasp.model import CartModel
from planning import WrenchPlanner
from planning.contacts.contact_relaxation import relax_contact_choice

CART = CartModel(Inertia(20.0, (0.3, 0.0), 2.0))
ONLY_PUSH = {"weights": (1.0, 1.0, 1.0, 1.0, 1.0, 1.0), "moment_limit": (0.0, 0.0, 0.0)}
BOX = {"force_limit": (40.0, 30.0, 30.0), "moment_limit": (4.0, 4.0, 3.0)}


def accuracy(found):
    return 1e-3 if found.status.endswith("inaccurate") else 1e-6


@pytest.mark.long
@given(tau=st.floats(-30, 30))
def test_two_points_and_forward_forces_in_closed_form(tau):
    """`fx_1 + fx_2 = fx` and `y (fx_2 - fx_1) = tau` fix both; the best shares give (|fx_1| + |fx_2|)²."""
    y, fx = 0.25, 40.0
    arm = Arm("hand", [(-0.25, y, 1.0), (-0.25, -y, 1.0)], force_limit=(np.inf, 0.0, np.inf), **ONLY_PUSH)
    found = relax_contact_choice(CART, [arm], (fx, 0.0, tau))
    each = np.array([fx - tau / y, fx + tau / y]) / 2
    assert found.bound == pytest.approx(np.abs(each).sum() ** 2, rel=accuracy(found))


def drawn(seed, n_arms):
    random = np.random.default_rng(seed)
    arms = []
    for i in range(n_arms):
        points = np.column_stack([np.full(6, -0.25), random.uniform(-0.4, 0.4, 6), np.ones(6)])
        friction = Friction(0.6, 4) if random.random() < 0.5 else None
        arms.append(Arm(f"arm{i}", points.tolist(), friction=friction, **BOX))
    wrench = random.uniform([5.0, -5.0, -6.0], [35.0, 5.0, 6.0]) * n_arms
    return arms, wrench


@pytest.mark.long
@settings(max_examples=25)
@given(seed=st.integers(0, 2**32), n_arms=st.sampled_from([1, 2]))
def test_bounds_the_exact_choice(seed, n_arms):
    arms, wrench = drawn(seed, n_arms)
    plan = WrenchPlanner(CART, arms).plan(wrench)
    found = relax_contact_choice(CART, arms, wrench)
    if plan.status == "optimal":
        assert found.gap(plan.effort) >= -accuracy(found)
        assert all(share.sum() == pytest.approx(1.0) for share in found.shares.values())
    elif not np.isfinite(found.bound):
        assert plan.status == "infeasible"


def test_exact_where_there_is_nothing_to_choose():
    arms = [Arm(name, [(-0.25, y, 1.0)], **BOX) for name, y in (("left", 0.2), ("right", -0.2))]
    plan = WrenchPlanner(CART, arms).plan((40.0, 0.0, 3.0))
    assert relax_contact_choice(CART, arms, (40.0, 0.0, 3.0)).gap(plan.effort) == pytest.approx(0.0, abs=1e-6)


def test_a_segment_is_a_mixture_of_its_ends():
    arm = Arm("hand", segment=[(-0.25, -0.3, 1.0), (-0.25, 0.3, 1.0)], **BOX)
    plan = WrenchPlanner(CART, [arm]).plan((30.0, 0.0, 2.0))
    found = relax_contact_choice(CART, [arm], (30.0, 0.0, 2.0))
    assert found.gap(plan.effort) + 1e-7 >= 0
    mixed = found.shares["hand"] @ np.array([-0.3, 0.3])
    assert mixed == pytest.approx(plan.contacts["hand"][1], abs=0.15)


def test_says_when_no_mixture_does():
    arms, _ = drawn(0, 1)
    found = relax_contact_choice(CART, arms, (500.0, 0.0, 0.0))
    assert (found.status, found.bound) == ("infeasible", np.inf)
