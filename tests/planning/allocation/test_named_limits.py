"""A certificate names the limits that hold the arms back, and no others: those that it names suffice, by HiGHS, and
none of them is infinite."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from cartgrasp.arms import Arm, Friction
from cartgrasp.joint_torques import JointTorques
from planning import InternalForce, WrenchPlanner
from planning.allocation.allocation_template import AllocationTemplate

from ..drawn import cart

MODEL, FAR = cart(), 1e5  # N, N·m: what HiGHS may use of what has no limit


def of_joints(bear):
    return {"joints": bear}


joints = st.integers(0, 2**31).map(
    lambda seed: JointTorques(
        np.random.default_rng(seed).normal(size=(6, 7)),
        np.random.default_rng(seed + 1).normal(size=7),
        np.random.default_rng(seed + 2).uniform(5.0, 50.0, 7),
    )
)
others = st.fixed_dictionaries(
    {},
    optional={
        "friction": st.floats(0.1, 1.0).map(lambda mu: Friction(mu, 5)),
        "payload": st.floats(0.5, 20.0),
        "force_limit": st.just((60.0, np.inf, 40.0)),
        "moment_limit": st.just((np.inf, 8.0, 6.0)),
        "yaw": st.floats(-1.0, 1.0),
    },
)
strengths = st.one_of(others, st.builds(lambda it, rest: rest | {"joints": it}, joints, others), joints.map(of_joints))
asked = st.tuples(st.floats(-900, 900), st.just(0.0), st.floats(-300, 300))
cart_limits = st.sampled_from([(), (InternalForce(5.0),), (InternalForce(3.0, (1.0, 0.0, 0.0)),)])


def kept_alone(template, contacts, names, direction):
    """The most along a direction that arms give which obey only the limits of these names."""
    fixed, of_cart = template.fixed, template.cart_rows
    matrix = template.contact_rows(contacts).transpose(1, 0, 2).reshape(-1, template.n)
    c = len(of_cart.low)
    rows = np.vstack([fixed.rows, matrix[:c]])
    lows = zip(fixed.low_names + of_cart.low_names, [*fixed.low_limits, *of_cart.low], -rows, strict=True)
    highs = zip(fixed.names + of_cart.high_names, [*fixed.limits, *of_cart.high], rows, strict=True)
    sides = [(row, -value) for name, value, row in lows if name in names and np.isfinite(value)]
    sides += [(row, value) for name, value, row in highs if name in names and np.isfinite(value)]
    lower = [v if name in names else -FAR for name, v in zip(fixed.lower_names, fixed.lower, strict=True)]
    upper = [v if name in names else FAR for name, v in zip(fixed.upper_names, fixed.upper, strict=True)]
    objective = -(template.basis_b.T @ np.asarray(direction)) @ matrix[c:]
    left, right = (np.array(part) if sides else None for part in (zip(*sides, strict=True) if sides else ((), ())))
    return -linprog(objective, left, right, bounds=list(zip(lower, upper, strict=True)), method="highs").fun


@settings(max_examples=60, deadline=None)
@given(strengths, strengths, asked, cart_limits)
def test_what_is_named_suffices_and_is_there(left, right, wrench, limits):
    arms = [Arm("left", [(-0.25, 0.2, 1.0)], **left), Arm("right", [(-0.25, -0.2, 1.0)], **right)]
    planner = WrenchPlanner(MODEL, arms, cart_limits=limits, relax=np.inf)
    plan = planner.plan(wrench)
    assert plan.status in ("optimal", "relaxed")
    if plan.status == "optimal":
        assert set(plan.active) <= set(plan.margins)  # these are of limits that are there
        return
    certificate = plan.certificate
    assert certificate.limits
    assert np.isfinite(list(certificate.limits.values())).all()
    assert "inf" not in certificate.words
    assert set(plan.active) <= set(plan.margins)
    template = AllocationTemplate.of(MODEL, arms, cart_limits=limits)
    contacts = np.array([arm.contacts.first for arm in arms])
    best = kept_alone(template, contacts, certificate.limits, certificate.direction)
    assert best == pytest.approx(certificate.most, rel=1e-5, abs=1e-3)
    assert best < certificate.asked


def test_joints_without_a_box_are_all_that_is_named():
    random = np.random.default_rng(0)
    bears = [JointTorques(random.normal(size=(6, 7)), random.normal(size=7), random.uniform(5, 50, 7)) for _ in "lr"]
    arms = [Arm(name, [(-0.25, y, 1.0)], joints=it) for name, y, it in zip("lr", (0.2, -0.2), bears, strict=True)]
    plan = WrenchPlanner(MODEL, arms).plan((900.0, 0.0, 30.0))
    assert plan.status == "infeasible"
    assert all("torque" in name for name in plan.certificate.limits)
