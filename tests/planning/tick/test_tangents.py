"""Half-spaces in place of margins' cones: a warm planner's plans are those of the general road, with their proof."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cartgrasp.contacts import grasp_map_spatial
from planning import SideForce, Skid, TipOver, WrenchPlanner
from planning.limits import FloorLimit, FloorRows, PushedCart
from planning.limits.robust import RobustLimits
from planning.tick.compiled_allocation import SOLVER
from planning.tick.tangents import Tangents, values_of

from ...core.drawn import vectors
from ..limits.test_robust import BEND, BITES, LEFT, LIMITS, REST, RIGHT, cart, covariance, estimate, hands

CONTACTS = {"left": LEFT, "right": RIGHT}
MAPS = grasp_map_spatial(np.array([LEFT, RIGHT]), np.zeros(2))
MANY = [Skid(0.3), TipOver(20.0), SideForce(12.0)]


def rows(motion, scale=1.0, limits=tuple(MANY)):
    return RobustLimits(limits, 0.99).rows(PushedCart(cart(), motion, hands()), covariance(scale))


def planners():
    both = [WrenchPlanner(cart(), hands(), cart_limits=LIMITS, confidence=0.99) for _ in range(2)]
    both[0].warm_up()
    return both


@pytest.fixture(scope="module")
def pair():
    return planners()


wrenches = st.tuples(st.floats(-100, 100), st.floats(-5, 5), st.floats(-20, 20))


@given(
    wrench=wrenches, scale=st.floats(0.05, 2.0), correlation=st.floats(-0.7, 0.7), motion=st.sampled_from([REST, BEND])
)
def test_a_warm_planner_plans_as_a_cold_one(pair, wrench, scale, correlation, motion):
    told = estimate(covariance(scale, correlation), motion)
    warm, cold = (planner.plan_or_hold(wrench, CONTACTS, told) for planner in pair)
    assert warm.status == cold.status
    if cold.status == "optimal":
        assert warm.effort == pytest.approx(cold.effort, rel=1e-6, abs=1e-9)
        program, solution = warm.proof
        assert solution.status == "optimal", solution.residuals
        assert len(program.cones) == len(solution.cone_multipliers) > 0


@pytest.mark.parametrize("name", BITES)
def test_where_margins_bite_it_is_the_compiled_road_that_answers(name):
    """Tick after tick, at contacts that are given, with a covariance that shrinks."""
    (wrench, motion), (warm, cold) = BITES[name], planners()
    for scale in np.linspace(1.0, 0.5, 8):
        told = estimate(covariance(scale), motion)
        plan, reference = (planner.plan_or_hold(wrench, CONTACTS, told) for planner in (warm, cold))
        assert plan.solver == SOLVER
        assert any("99 %" in limit for limit in plan.active)
        assert set(plan.active) == set(reference.active)
        assert plan.proof[1].status == "optimal"
        for arm, own in reference.wrenches.items():
            np.testing.assert_allclose(plan.wrenches[arm], own, atol=1e-5)


def test_what_margins_forbid_is_said_at_once():
    """Half-spaces that leave nothing prove that cones leave nothing."""
    warm, cold = planners()
    told = estimate(covariance(), BEND)
    plan, reference = (planner.plan_or_hold((-120.0, 0.0, 20.0), CONTACTS, told) for planner in (warm, cold))
    assert plan.status == reference.status == "infeasible"
    assert plan.solver == SOLVER
    assert plan.certificate.verified
    assert plan.certificate.asked == pytest.approx(reference.certificate.asked, rel=1e-6)


@pytest.mark.parametrize(("scale", "status"), [(12.0, "infeasible"), (1.0, "relaxed")])
def test_margins_that_no_wrench_keeps_cost_no_search(scale, status, monkeypatch):
    """Nor does the nearest wrench that keeps them."""
    warm, cold = (WrenchPlanner(cart(), hands(), cart_limits=LIMITS, confidence=0.99, relax=np.inf) for _ in range(2))
    warm.warm_up()
    told = estimate(covariance(scale), BEND)
    with monkeypatch.context() as patched:
        patched.setattr("planning.solvers.QuadraticSolver.solve", None)
        plan = warm.plan_or_hold((-120.0, 0.0, 20.0), CONTACTS, told)
        assert plan.status == status
    reference = cold.plan_or_hold((-120.0, 0.0, 20.0), CONTACTS, told)
    assert reference.status == status
    assert plan.certificate.asked == pytest.approx(reference.certificate.asked, rel=1e-6)
    np.testing.assert_allclose(plan.cart_wrench, reference.cart_wrench, atol=1e-3)


def test_the_nearest_is_found_where_several_margins_bend(monkeypatch):
    """Half-spaces alone go to and fro about it."""
    warm, cold = (WrenchPlanner(cart(), hands(), cart_limits=MANY, confidence=0.99, relax=np.inf) for _ in range(2))
    warm.warm_up()
    generator, found = np.random.default_rng(8), []
    for _ in range(60):
        wrench = generator.normal(size=3) * (120.0, 5.0, 40.0)
        told = estimate(covariance(generator.uniform(0.3, 2.0)), (REST, BEND)[generator.integers(2)])
        with monkeypatch.context() as patched:
            patched.setattr("planning.solvers.QuadraticSolver.solve", None)
            plan = warm.plan_or_hold(wrench, CONTACTS, told)
        reference = cold.plan_or_hold(wrench, CONTACTS, told)
        assert plan.status == reference.status
        found.append(plan.status)
        if plan.status == "relaxed":
            np.testing.assert_allclose(plan.cart_wrench, reference.cart_wrench, atol=1e-3)
    assert found.count("relaxed") > 20


@given(at=vectors(12, -60.0, 60.0), weights=vectors(4, 0.0, 5.0))
def test_the_curvature_is_that_of_the_cones_lengths(at, weights):
    robust = rows(BEND)
    tangents = Tangents.touching(robust, values_of(robust, at, MAPS))
    c, n = len(robust.cones), robust.n_plain
    linear = np.concatenate([np.zeros(n), -np.resize(weights, c)])

    def weighed(whole):
        s = robust.cone_offsets + (robust.of_sum[n:] @ whole).reshape(c, -1)
        return -linear[n:] @ np.linalg.norm(s[:, 1:], axis=1)

    whole, step, axes = MAPS.transpose(1, 0, 2).reshape(6, -1) @ at, 1e-2, np.eye(6)
    numeric = [
        [
            sum(a * b * weighed(whole + step * (a * axes[i] + b * axes[j])) for a in (1, -1) for b in (1, -1))
            for j in range(6)
        ]
        for i in range(6)
    ]
    found = tangents.curvature(values_of(robust, at, MAPS), linear)
    np.testing.assert_allclose(found, np.array(numeric) / (4 * step**2), atol=1e-4 * (1.0 + np.abs(found).max()))


@given(held=vectors(12, -60.0, 60.0), other=vectors(12, -60.0, 60.0))
def test_half_spaces_hold_whatever_the_cones_hold(held, other):
    """And touch them where they are said to, but for margins that don't depend on the wrench."""
    robust = rows(BEND)
    at_held, at_other = (values_of(robust, each, MAPS) for each in (held, other))
    tangents = Tangents.touching(robust, at_held)
    linear = tangents.linear
    assert not linear.cones
    room = [
        values_of(linear, each, MAPS)[-len(robust.cones) :] - linear.low[-len(robust.cones) :] for each in (held, other)
    ]
    cones = [
        [s[0] - np.linalg.norm(s[1:]) for c in robust.cones for s in [c.offset + v[c.own]]] for v in (at_held, at_other)
    ]
    np.testing.assert_allclose(room[0], cones[0], atol=1e-7)
    assert (room[1] >= np.array(cones[1]) - 1e-7).all()
    assert (tangents.turned(at_other, 1.0) is None) == bool((np.array(cones[1]) >= -1e-9).all())


class RearLoad(FloorLimit):
    """A user's own: casters carry some share of the weight at most."""

    def on_floor(self, cart):
        casters = cart.wheel_set.is_caster
        mix = np.array([[*np.where(casters, 0.4, -0.6), 0.0]])
        return FloorRows(mix, np.full(1, -np.inf), np.zeros(1), ("casters' share",), ("casters' share",))


@pytest.mark.parametrize("limit", [*MANY, RearLoad()], ids=lambda limit: type(limit).__name__)
@pytest.mark.parametrize("motion", [REST, BEND])
def test_cones_spread_as_rows_do_for_carts_that_differ(limit, motion):
    """By central differences along each deviation of the covariance."""
    deviations = np.linalg.cholesky(covariance()).T

    def row(step):
        there = cart().with_parameters(cart().parameters + step)
        rows = limit.rows(PushedCart(there, motion, hands()))
        low, high = np.flatnonzero(np.isfinite(rows.low)), np.flatnonzero(np.isfinite(rows.high))
        sides = [np.append(-rows.of_sum[i], rows.low[i]) for i in low]
        return np.array(sides + [np.append(rows.of_sum[i], -rows.high[i]) for i in high])

    slopes = np.array([(row(1e-5 * way) - row(-1e-5 * way)) / 2e-5 for way in deviations])
    made = rows(motion, limits=(limit,))
    factor = NormalDist().inv_cdf(1 - 0.01 / len(made.cones))
    for i, cone in enumerate(made.cones):
        own = np.column_stack([made.of_sum[cone.own], cone.offset])
        np.testing.assert_allclose(own[0], -row(np.zeros(4))[i], rtol=1e-9, atol=1e-9)
        expected = factor**2 * slopes[:, i].T @ slopes[:, i]
        np.testing.assert_allclose(own[1:].T @ own[1:], expected, rtol=1e-4, atol=1e-6 * np.abs(expected).max())
