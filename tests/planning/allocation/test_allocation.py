"""Allocations against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.arms import Arm, Friction
from cartgrasp.errors import UsageError
from planning import WrenchPlanner, allocate, build_allocation

from ..drawn import StretchedArm, arm, bar, cart, effective_matrix, first_contacts, random_arms, random_cart

numbers = st.floats(-40, 40)
TIGHT = {"rel": 1e-9, "abs": 1e-9}


def free_arm(name, contact, **changes):
    return Arm(name, [contact], **changes)


@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(0, 40), numbers)
def test_one_contact_splits_the_moment_between_side_force_and_torque(px, py, force, moment):
    """fx is given; min w_y fy² + w_t tz² with px fy + tz = tau + py fx =: c."""
    a = free_arm("left", (px, py, 1.0), weights=(1, 2, 1, 10, 10, 5))
    found = allocate(cart(), [a], first_contacts([a]), (force, 0, moment))
    c = moment + py * force
    share = c / (px**2 / 2 + 1 / 5)
    assert found.wrenches["left"] == pytest.approx([force, share * px / 2, 0, 0, 0, share / 5], **TIGHT)
    assert found.effort == pytest.approx(
        force**2 + 2 * (share * px / 2) ** 2 + 5 * (share / 5) ** 2, rel=1e-9, abs=1e-9
    )


def test_a_symmetric_pair_shares_alike():
    arms = [arm("left", [(-0.25, 0.2, 1.0)]), arm("right", [(-0.25, -0.2, 1.0)])]
    found = allocate(cart(), arms, first_contacts(arms), (50, 0, 0))
    for name in ("left", "right"):
        assert found.wrenches[name] == pytest.approx([25, 0, 0, 0, 0, 0], abs=1e-9)
    assert found.effort == pytest.approx(1250, rel=1e-12)
    assert found.active == ()


def test_joints_bear_what_they_do_at_the_contact():
    """As `WrenchPlanner` has it: 20 N at most where the arm is stretched, though the first contact is nearer."""
    arms, far = [arm("left", [(-0.25, 0.0, 1.0), (-0.5, 0.0, 1.0)], joints=StretchedArm())], {"left": (-0.5, 0.0, 1.0)}
    for force, status in ((19.0, "optimal"), (21.0, "infeasible")):
        assert allocate(cart(), arms, far, (force, 0, 0)).status == status
        assert WrenchPlanner(cart(), arms).plan((force, 0, 0), far).status == status
        assert allocate(cart(), arms, first_contacts(arms), (force, 0, 0)).status == "optimal"


@pytest.mark.parametrize("seed", range(20))
def test_without_limits_it_is_the_weighted_pseudo_inverse(seed):
    """F = W⁻¹ Aᵀ (A W⁻¹ Aᵀ)⁻¹ b, for carts with 0, 1 and 2 constraint rows."""
    rng = np.random.default_rng(seed)
    model = random_cart(rng)
    arms = [
        free_arm(f"arm{i}", rng.uniform(-0.5, 0.5, 3), yaw=rng.uniform(-3, 3), weights=rng.uniform(0.5, 12, 6))
        for i in range(rng.integers(1, 5))
    ]
    wrench = rng.uniform(-40, 40, 3)
    found = allocate(model, arms, first_contacts(arms), wrench)
    matrix = effective_matrix(model, arms, first_contacts(arms))
    inverse = np.diag(1 / np.concatenate([a.weights for a in arms]))
    expected = inverse @ matrix.T @ np.linalg.solve(matrix @ inverse @ matrix.T, model.constraints.basis_b.T @ wrench)
    assert np.concatenate(list(found.wrenches.values())) == pytest.approx(expected, **TIGHT)
    assert found.solution.residuals.equality <= 1e-9


@pytest.mark.parametrize(("moment", "edges"), [(40.0, (1, 2)), (-40.0, (3, 0))])
def test_an_active_friction_edge(moment, edges):
    """A contact behind the axle wants more side force than mu fx: fy = -+ mu fx, tz takes the rest."""
    force, mu, px = 30.0, 0.3, -0.5
    a = arm("left", [(px, 0.0, 1.0)], friction=Friction(mu, 4), moment_limit=(np.inf,) * 3)
    found = allocate(cart(), [a], first_contacts([a]), (force, 0, moment))
    side = -np.sign(moment) * mu * force
    assert found.wrenches["left"] == pytest.approx([force, side, 0, 0, 0, moment - px * side], **TIGHT)
    assert set(found.active) == {f"left: friction edge {k}" for k in edges}


def test_limits_of_a_pair_push_the_load_over():
    """Left may give 10 N only: right gives the rest; offset (y = 0.2) and moment are balanced by side force
    and tz."""
    arms = [
        arm("left", [(0.0, 0.2, 1.0)], force_limit=(10, 60, 40), friction=None),
        arm("right", [(0.0, -0.2, 1.0)], friction=None),
    ]
    found = allocate(cart(), arms, first_contacts(arms), (50, 0, 0))
    # px = 0: side force makes no moment. 0.2 (40 - 10) = 6 N·m is undone by tz alone, half each.
    assert found.wrenches["left"] == pytest.approx([10, 0, 0, 0, 0, -3], abs=1e-9)
    assert found.wrenches["right"] == pytest.approx([40, 0, 0, 0, 0, -3], abs=1e-9)
    assert found.active == ("left: fx upper",)


@given(st.floats(0.2, 1.5), st.floats(0.0, 8.0), st.floats(-0.2, 0.2))
def test_least_moment_contact_of_a_handle(acceleration, drag, com_y):
    """Physics 14: fx = m u' + drag, tau = -m dy u'; py* = m dy u' / (m u' + drag) needs neither fy nor tz."""
    mass = 20.0
    force = mass * acceleration + drag
    best = mass * com_y * acceleration / force
    planner = WrenchPlanner(cart(), [bar("left")])
    plan = planner.plan((force, 0.0, -mass * com_y * acceleration))
    assert plan.effort == pytest.approx(force**2, rel=1e-9)
    assert plan.contacts["left"] == pytest.approx([-0.25, best, 1.0], abs=2e-5)  # the gap allows 1e-9 of effort
    assert plan.wrenches["left"] == pytest.approx([force, 0, 0, 0, 0, 0], abs=1e-3)
    assert plan.choice.gap <= 1e-9


def test_a_rail_needs_one_row():
    arms = [arm("left"), arm("right", [(-0.25, -0.1, 1.0)], weights=(3, 1, 1, 10, 10, 10))]
    program = build_allocation(cart(2), arms, first_contacts(arms), (40, 7, 3))
    assert program.equality[0].shape == (1, 12)
    found = allocate(cart(2), arms, first_contacts(arms), (40, 7, 3))
    assert found.wrenches["left"] == pytest.approx([30, 0, 0, 0, 0, 0], abs=1e-9)
    assert found.wrenches["right"] == pytest.approx([10, 0, 0, 0, 0, 0], abs=1e-9)


def test_a_cart_without_constraint_needs_three_rows():
    arms = [arm("left"), arm("right", [(-0.25, -0.2, 1.0)])]
    wrench = np.array([40.0, 7.0, 3.0])
    program = build_allocation(cart(0), arms, first_contacts(arms), wrench)
    assert program.equality[0].shape == (3, 12)
    found = allocate(cart(0), arms, first_contacts(arms), wrench)
    total = effective_matrix(cart(0), arms, first_contacts(arms)) @ np.concatenate(list(found.wrenches.values()))
    assert total == pytest.approx(wrench, abs=1e-9)


def test_an_axle_off_the_origin_lets_side_force_turn_the_cart():
    """Effective row tau - a fy: with px = a side force has no lever about the axle."""
    a = free_arm("left", (0.4, 0.0, 1.0))
    found = allocate(cart(1, axle_x=0.4), [a], first_contacts([a]), (10, 5, 3))
    assert found.wrenches["left"] == pytest.approx([10, 0, 0, 0, 0, 3 - 0.4 * 5], abs=1e-9)


def test_the_program_says_what_it_is():
    arms = random_arms(np.random.default_rng(1), 2, sides=4)
    program = build_allocation(cart(), arms, first_contacts(arms), (1, 0, 0))
    assert program.hessian == pytest.approx(2 * np.diag(np.concatenate([a.weights for a in arms])))
    assert program.upper_names[0] == "arm0: fx upper"
    assert program.lower_names[0] == "arm0: push only"
    assert program.lower_names[5] == "arm0: tz lower"
    assert program.upper_names[12:20] == tuple(f"arm{i}: friction edge {k}" for i in range(2) for k in range(4))
    x = np.arange(12.0)
    cost = x @ program.hessian @ x / 2 + program.gradient @ x + program.constant
    assert cost == pytest.approx(np.concatenate([a.weights for a in arms]) @ x**2)


def test_contacts_must_name_the_arms():
    with pytest.raises(UsageError, match="right"):
        build_allocation(cart(), [arm("left")], {"right": (0, 0, 0)}, (1, 0, 0))
    with pytest.raises(UsageError, match="three finite numbers"):
        build_allocation(cart(), [arm("left")], {"left": (0, np.nan, 0)}, (1, 0, 0))
    with pytest.raises(UsageError, match="stands twice"):
        build_allocation(cart(), [arm("left"), arm("left")], {"left": (0, 0, 0)}, (1, 0, 0))
