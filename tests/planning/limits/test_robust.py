"""Margins hold what they promise: Monte Carlo over the estimate's covariance, a closed form, and cvxpy."""

from __future__ import annotations

from statistics import NormalDist

import cvxpy
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import cartgrasp as cg
from cartgrasp.contacts import grasp_map_planar, grasp_map_spatial
from cartgrasp.inertia import physical_jacobian
from cartgrasp.motion import Motion
from planning import InternalForce, SideForce, Skid, TipOver, WrenchPlanner
from planning.limits import FloorLimit, FloorRows, PushedCart
from planning.limits.robust import RobustLimits, root

from ..contacts.test_contact_choice_with_cart_limits import WHEELS

MASS, COM, INERTIA, HEIGHT = 24.0, (0.3, 0.02), 2.0, 0.45
DEVIATIONS = np.array([1.0, 0.015, 0.01, 0.2])
"""Of mass, CoM and inertia."""
LIMITS = (Skid(0.3), TipOver(20.0))
LEFT, RIGHT = (-0.25, 0.2, 1.0), (-0.25, -0.2, 1.0)
REST = Motion(np.zeros(3), np.zeros(2))
BEND = Motion(np.zeros(3), np.array([0.9, 0.5]))


def cart(**changes):
    inertia = cg.Inertia(MASS, COM, INERTIA)
    return cg.CartModel(
        inertia, **({"constraints": cg.RollingConstraints(0.0), "wheels": WHEELS} | changes), com_height=HEIGHT
    )


def hands(**changes):
    limits = {"force_limit": (120, 60, 60), "moment_limit": (8, 8, 8)} | changes
    return [cg.Arm("left", [LEFT], **limits), cg.Arm("right", [RIGHT], **limits)]


def covariance(scale=1.0, correlation=0.0):
    """Of phi, (4, 4): deviations of the physical values, mass and CoM correlated."""
    to_phi = np.linalg.inv(physical_jacobian(cart().inertia.phi))
    physical = np.diag((scale * DEVIATIONS) ** 2)
    physical[0, 1] = physical[1, 0] = correlation * scale**2 * DEVIATIONS[0] * DEVIATIONS[1]
    return to_phi @ physical @ to_phi.T


def estimate(covariance, motion=REST, model=None, time=0.0):
    model = model or cart()
    return cg.Estimate(time, motion, {}, "", model, model.parameters, covariance)


def plan_with(wrench, covariance, motion=REST, confidence=0.99, **changes):
    planner = WrenchPlanner(cart(), hands(**changes), cart_limits=LIMITS, confidence=confidence)
    return planner.plan_or_hold(wrench, estimate=estimate(covariance, motion))


BITES = {"braking": ((-85, 0, 0), REST), "turning": ((40, 0, 17), REST), "in a bend": ((20, 0, 16), BEND)}


@pytest.mark.parametrize("name", BITES)
@pytest.mark.parametrize(("scale", "correlation"), [(0.5, 0.0), (1.0, 0.0), (1.0, -0.7)])
def test_monte_carlo(name, scale, correlation):
    """Of many carts drawn from what is believed, at most 1 % break any limit; of the plain plan's at a limit, half."""
    (wrench, motion), n = BITES[name], 20000
    spread = covariance(scale, correlation)
    robust, nominal = plan_with(wrench, spread, motion), plan_with(wrench, spread, motion, confidence=None)
    assert robust.status == nominal.status == "optimal", robust.message
    assert all("99 %" in limit for limit in robust.active if "skid" in limit or "wheel" in limit)
    draws = np.random.default_rng(7).multivariate_normal(cart().parameters, spread, n, method="cholesky")
    shares = [breaks(plan, draws, motion).mean() for plan in (robust, nominal)]
    assert shares[0] <= 0.01 + 3 * (0.01 * 0.99 / n) ** 0.5
    assert shares[0] > 0.0, "margins no wider than they need be"
    assert shares[1] > 0.4


@pytest.mark.parametrize("name", ["turning", "in a bend"])
def test_monte_carlo_of_the_side_force(name):
    (wrench, motion), n = BITES[name], 20000
    draws = np.random.default_rng(8).multivariate_normal(cart().parameters, covariance(), n, method="cholesky")
    shares = []
    for confidence in (0.99, None):
        planner = WrenchPlanner(cart(), hands(), cart_limits=[SideForce(12.0)], confidence=confidence)
        plan = planner.plan(wrench, estimate=estimate(covariance(), motion))
        assert plan.status == "optimal"
        assert any("side force" in limit for limit in plan.active)
        shares.append((np.abs(floor_under(plan, draws, motion)[1]) > 12.0).mean())
    assert 0.0 < shares[0] <= 0.01 + 3 * (0.01 * 0.99 / n) ** 0.5
    assert shares[1] > 0.4


def breaks(plan, phi, motion):
    """Which of many carts phi (n, 4) break a limit."""
    loads, lateral = floor_under(plan, phi, motion)
    return (loads.min(axis=0) < 20.0) | (np.abs(lateral) > 0.3 * loads[:2].sum(axis=0))


def floor_under(plan, phi, motion):
    """Loads and lateral force of many carts phi (n, 4): by the accelerations of each, and moments on it."""
    (m, mx, my, J), (u, r) = phi.T, motion.velocity
    W = sum(grasp_map_spatial(plan.contacts[name]) @ wrench for name, wrench in plan.wrenches.items())
    push, turn, determinant = W[0] + mx * r**2, W[5] - mx * u * r, m * J - my**2
    du, dr = (J * push + my * turn) / determinant, (my * push + m * turn) / determinant
    along, across = m * du - my * dr - mx * r**2, m * u * r + mx * dr - my * r**2  # of the momentum, in N
    balance = [9.81 * m - W[2], 9.81 * mx + W[4] - HEIGHT * along, 9.81 * my - W[3] - HEIGHT * across]
    loads = np.linalg.pinv([np.ones(4), *np.array([[w.x, w.y] for w in WHEELS]).T]) @ balance
    return loads, across - W[1]


@settings(max_examples=25, deadline=None)
@given(st.floats(0.1, 1.5), st.floats(0.1, 1.0), st.sampled_from([0.9, 0.99, 0.999]))
def test_closed_form_of_one_hand_on_a_rail(s_x, s_y, confidence):
    """Braked by one hand at height z, a front wheel carries (m g dx - (z - h) f) / (2 x_f) + y m g dy / sum y²: affine
    in m dx and m dy, of which s_x and s_y are the deviations (kg m). The hardest braking leaves it q deviations."""
    model = cart(constraints=cg.RollingConstraints(0.0, no_rotation=True))
    hand = cg.Arm("hand", [(-0.25, 0.0, 1.0)], force_limit=(400, 0, 0), moment_limit=(0, 0, 0))
    planner = WrenchPlanner(model, [hand], cart_limits=[TipOver(5.0)], confidence=confidence, relax=np.inf)
    plan = planner.plan(
        (-390, 0, 0), estimate=estimate(np.diag([0, s_x, s_y, 0]) ** 2, Motion(np.zeros(3), np.zeros(1)), model)
    )
    quantile = NormalDist().inv_cdf(1 - (1 - confidence) / 4)
    squares = 2 * 0.27**2 + 2 * 0.2**2
    deviation = 9.81 * np.hypot(s_x / (2 * 0.72), 0.2 * s_y / squares)
    sideways = 0.2 * 9.81 * MASS * COM[1] / squares
    least = 5.0 + quantile * deviation + sideways
    force = (MASS * 9.81 * COM[0] - least * 2 * 0.72) / (1.0 - HEIGHT)
    if force < 0:
        assert plan.status in ("relaxed", "infeasible")
        return
    assert plan.status == "relaxed"
    assert plan.contact_wrenches.wrench_b[0] == pytest.approx(-force, rel=1e-6)
    assert f"wheel 3 load ({100 * confidence:g} %)" in plan.active


def test_no_covariance_no_margins():
    """Zero covariance, no estimate yet, or no confidence: the same plan."""
    wrench = BITES["turning"][0]
    plain = plan_with(wrench, None, confidence=None)
    before = WrenchPlanner(cart(), hands(), cart_limits=LIMITS, confidence=0.99).plan(wrench)
    for plan in (plan_with(wrench, np.zeros((4, 4))), plan_with(wrench, covariance(), confidence=None), before):
        assert plan.active == plain.active
        for name, expected in plain.wrenches.items():
            assert plan.wrenches[name] == pytest.approx(expected, rel=1e-10, abs=1e-12)


@pytest.mark.parametrize("name", BITES)
def test_more_doubt_never_costs_less(name):
    wrench, motion = BITES[name]
    efforts = [plan_with(wrench, covariance(scale), motion).effort for scale in (0.0, 1e-4, 0.1, 0.3, 0.6, 1.0)]
    assert (np.diff(efforts) >= -1e-7 * efforts[0]).all()
    assert efforts[1] == pytest.approx(efforts[0], rel=1e-3)
    assert efforts[-1] > 1.02 * efforts[0]
    bolder = plan_with(wrench, covariance(), motion, confidence=0.9).effort
    assert efforts[0] < bolder < efforts[-1]


def test_margins_follow_the_estimate_from_call_to_call():
    """One planner, warm, told more and less: each plan is that of a planner made for it."""
    planner = WrenchPlanner(cart(), hands(), cart_limits=(*LIMITS, InternalForce(30.0)), confidence=0.99)
    planner.warm_up()
    for time, scale in enumerate((1.0, 0.0, 0.0, 0.5, 0.5, 0.0)):
        plan = planner.plan((40, 0, 17), estimate=estimate(covariance(scale), time=float(time)))
        fresh = WrenchPlanner(cart(), hands(), cart_limits=(*LIMITS, InternalForce(30.0)), confidence=0.99)
        assert plan.effort == pytest.approx(
            fresh.plan((40, 0, 17), estimate=estimate(covariance(scale))).effort, rel=1e-8
        )
        assert {"internal force of left upper", "wheel 0 load" + (" (99 %)" if scale else "")} <= set(plan.margins)
        assert plan.residuals.proven


def reaction(physical):
    """Matrix and offset over both hands' wrenches (12,) of the sides `g <= 0`, at rest: by forces and accelerations."""
    m, dx, dy, inertia = physical
    J = inertia + m * (dx**2 + dy**2)
    hand_map = np.hstack([grasp_map_spatial(LEFT), grasp_map_spatial(RIGHT)])
    du, dr = np.linalg.solve([[m, -m * dy], [-m * dy, J]], hand_map[[0, 5]])
    along, across = hand_map[4] - HEIGHT * m * (du - dy * dr), -hand_map[3] - HEIGHT * m * dx * dr
    x, y = np.array([[w.x, w.y] for w in WHEELS]).T
    springs = np.linalg.pinv(np.vstack([np.ones(4), x, y]))
    loads, at_rest = springs @ np.array([-hand_map[2], along, across]), springs @ (m * 9.81 * np.array([1.0, dx, dy]))
    lateral = m * dx * dr - hand_map[1]
    carried, carried_at_rest = 0.3 * loads[:2].sum(axis=0), 0.3 * at_rest[:2].sum()
    matrix = np.vstack([lateral - carried, -lateral - carried, -loads])
    return matrix, np.concatenate([[-carried_at_rest] * 2, 20.0 - at_rest])


@pytest.mark.parametrize("wrench", [(-85, 0, 0), (40, 0, 17), (-60, 0, 10), (30, 0, 2)])
def test_the_formula_in_cvxpy_agrees(wrench):
    """Written down again, its slopes taken by the physical values."""
    here = np.array([MASS, *COM, INERTIA])
    matrix, offset = reaction(here)
    slopes = []
    for step in np.diag(1e-5 * DEVIATIONS):
        (up, up_offset), (down, down_offset) = reaction(here + step), reaction(here - step)
        slopes.append(((up - down) / 2e-5, (up_offset - down_offset) / 2e-5))
    F, quantile = cvxpy.Variable(12), NormalDist().inv_cdf(1 - 0.01 / 6)
    held = [cvxpy.abs(F) <= np.tile([120, 60, 60, 8, 8, 8], 2)]
    held += [np.hstack([grasp_map_planar(p)[[0, 2]] for p in (LEFT, RIGHT)]) @ F == np.array([wrench[0], wrench[2]])]
    for k in range(6):
        deviation = cvxpy.norm(cvxpy.hstack([slope[k] @ F + value[k] for slope, value in slopes]))
        held.append(matrix[k] @ F + offset[k] + quantile * deviation <= 0)
    cost = cvxpy.sum_squares(cvxpy.multiply(np.sqrt(np.tile(hands()[0].weights, 2)), F))
    tight = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), 1e-10)
    best = cvxpy.Problem(cvxpy.Minimize(cost), held).solve(solver=cvxpy.CLARABEL, **tight)
    plan = plan_with(wrench, covariance())
    assert plan.status == "optimal"
    assert plan.effort == pytest.approx(best, rel=1e-6)
    assert plan.residuals.proven


@pytest.mark.parametrize("wrench", [(-130, 0, 0), (-70, 0, 25), (-300, 0, -12)])
def test_what_can_not_be_held_is_certified(wrench):
    plan = plan_with(wrench, covariance(2.0))
    assert plan.status == "infeasible"
    assert plan.certificate.verified
    assert "(99 %)" in plan.message
    assert plan_with(plan.nearest.wrench * (1 - 1e-6), covariance(2.0)).status == "optimal"
    direction = np.array(plan.certificate.direction)
    beyond = plan.nearest.wrench + 1e-3 * direction / np.linalg.norm(direction)
    assert plan_with(beyond, covariance(2.0)).status == "infeasible"


def test_a_doubt_that_no_wrench_outweighs_is_a_contradiction():
    """In a fast bend weak hands can't keep the margin of the wheels' side force, whatever is asked."""
    motion = Motion(np.zeros(3), np.array([1.5, 1.0]))
    weak = {"force_limit": (5, 2, 2)}
    assert plan_with((3, 0, 0), np.zeros((4, 4)), motion, **weak).status == "optimal"
    plan = plan_with((3, 0, 0), covariance(4.0), motion, **weak)
    assert plan.status == "infeasible"
    assert plan.certificate.verified
    assert "(99 %) by " in plan.certificate.words
    assert plan.nearest is None


def test_limits_free_of_the_cart_stay_rows():
    rows = RobustLimits((InternalForce(5.0),), 0.99).rows(PushedCart(cart(), REST, hands()), covariance())
    assert rows.cones == ()
    assert rows.high.tolist() == [5.0]


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 6), st.integers(0, 2**31))
def test_root(rank, seed):
    rng = np.random.default_rng(seed)
    factor = 10.0 ** rng.uniform(-4, 4, (6, 1)) * rng.normal(size=(6, rank))
    found = root(factor @ factor.T)
    assert found.shape[1] <= 6
    scale = np.linalg.norm(factor, axis=1) if rank else np.ones(6)
    assert found @ found.T == pytest.approx(factor @ factor.T, abs=1e-9 * scale.max() ** 2)


def test_the_largest_confidence_has_a_margin():
    largest = np.nextafter(1.0, 0.0)
    found = RobustLimits((SideForce(50.0),), largest).rows(PushedCart(cart(), REST, hands()), covariance())
    less = RobustLimits((SideForce(50.0),), 1 - 1e-12).rows(PushedCart(cart(), REST, hands()), covariance())
    assert np.isfinite(found.of_sum).all()
    assert (np.abs(found.of_sum) >= np.abs(less.of_sum)).all()


@pytest.mark.parametrize("wrong", [0.4, 1.0, np.nan, -1])
def test_confidence_that_is_none(wrong):
    with pytest.raises(cg.UsageError, match="confidence"):
        WrenchPlanner(cart(), hands(), confidence=wrong)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (None, "no covariance"),
        (np.eye(3), "shape"),
        (np.full((4, 4), np.nan), "not finite"),
        (np.diag([1.0, -1.0, 1.0, 1.0]), "diagonal"),
        (np.eye(4) + np.eye(4, k=1), "not symmetric"),
        (np.eye(4) + 2 * np.eye(4, k=1) + 2 * np.eye(4, k=-1), "positive semidefinite"),
    ],
)
def test_covariances_that_are_refused(wrong, words):
    plan = plan_with((10, 0, 1), wrong)
    assert plan.status == "invalid_input"
    assert words in plan.message


class Wrong(FloorLimit):
    def __init__(self, changes):
        self.changes = changes

    def on_floor(self, cart):
        if self.changes is None:
            return None
        fields = {"mix": np.zeros((1, 5)), "low": np.zeros(1), "high": np.ones(1), "low_names": ("a",)}
        return FloorRows(**(fields | {"high_names": ("b",)} | self.changes))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"mix": np.zeros((1, 4))}, "give mix \\(k, 5\\)"),
        ({"low": np.zeros(2)}, "give mix"),
        ({"low_names": ()}, "k names each"),
        ({"low": np.full(1, np.nan)}, "a number that is none"),
        ({"mix": np.full((1, 5), np.inf)}, "a number that is none"),
        ({"high_names": ("",)}, "empty name"),
        (None, "None is no FloorRows"),
    ],
)
def test_rows_from_outside_are_looked_at(changes, words):
    with pytest.raises(cg.UsageError, match="Wrong: its rows on the floor.*" + words):
        WrenchPlanner(cart(), hands(), cart_limits=[Wrong(changes)])
