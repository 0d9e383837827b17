"""The judge of ticks is judged: by closed forms, by Clarabel, and by the planner's own margins."""

from __future__ import annotations

import clarabel
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from cartgrasp.contacts import grasp_map_spatial
from planning import Skid, TipOver
from planning.limits import PushedCart
from planning.limits.robust import RobustLimits

from ..limits.test_robust import BEND, LEFT, REST, RIGHT, cart, covariance, estimate, hands
from ..mirror import Cost, Holds, Mirror
from ..tick_judge import GAP, suboptimality


def drawn(seed, n=6, n_rows=8):
    """A convex program with a degenerate corner: rows that are nearly the same."""
    rng = np.random.default_rng(seed)
    factor = rng.normal(size=(rng.integers(0, n + 1), n))
    rows = rng.normal(size=(n_rows, n))
    rows[1] = rows[0] + 1e-5 * rows[1]
    holds = Holds(np.vstack([rows, np.eye(n), -np.eye(n)]), np.ones(n_rows + 2 * n), [], rng.normal(size=(2, n)))
    return holds, Cost(factor.T @ factor, rng.normal(size=n), np.zeros((0, n + 1))), rng


def best(holds, cost):
    cones = [clarabel.ZeroConeT(len(holds.matrix)), clarabel.NonnegativeConeT(len(holds.rows))]
    values = np.concatenate([np.zeros(len(holds.matrix)), holds.limits])
    tight = clarabel.DefaultSettings()
    tight.verbose, tight.tol_gap_abs, tight.tol_gap_rel, tight.tol_feas = False, 1e-12, 1e-12, 1e-12
    rows = sparse.csc_matrix(np.vstack([holds.matrix, holds.rows]))
    hessian = sparse.csc_matrix(np.triu(cost.hessian))
    return np.array(clarabel.DefaultSolver(hessian, cost.gradient, rows, values, cones, tight).solve().x)


def value(cost, x):
    return 0.5 * x @ cost.hessian @ x + cost.gradient @ x


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**31), st.floats(-8, 0))
def test_what_it_says_is_never_below_the_truth(seed, exponent):
    """None for what is best; off it, towards zero, which all rows hold, at least by how much more that costs."""
    holds, cost, _ = drawn(seed)
    x = best(holds, cost)
    assert suboptimality(holds, cost, x) <= GAP
    off = (1 - 10.0**exponent) * x
    more = (value(cost, off) - value(cost, x)) / max(1.0, 0.5 * off @ cost.hessian @ off + abs(cost.gradient @ off))
    slope = np.abs(cost.hessian @ off + cost.gradient).max()
    forgiven = 1e-6 * max(1.0, slope) * np.abs(x - off).sum()  # the residual's part
    assert suboptimality(holds, cost, off) >= more - forgiven - 1e-11


def test_a_corner_that_is_hardly_one():
    """Most of y under `y + 1e-5 x <= 1` and `x >= 0`: a point 1e-9 below the best is 1e-4 from the row that, beside the
    other, explains why the best is best. Its slope is 1e-5 off what touched rows explain; it costs 1e-9 more."""
    holds = Holds(np.array([[1e-5, 1.0], [-1.0, 0.0]]), np.array([1.0, 0.0]), [], np.zeros((1, 2)))
    cost = Cost(np.zeros((2, 2)), np.array([0.0, -1.0]), np.zeros((0, 3)))
    assert suboptimality(holds, cost, np.array([0.0, 1.0])) == pytest.approx(0.0, abs=1e-15)
    for along in (1e-4, 1.0, 1e3):
        y = 1.0 - 1e-5 * along
        # 1e-6 of the slope is within tolerance: of the multiplier of 1e-5 there need be 9e-6
        found = suboptimality(holds, cost, np.array([along, y]))
        assert 0.9e-5 * along * (1 - 1e-5) <= found <= 1e-5 * along


@pytest.mark.parametrize("motion", [REST, BEND], ids=("at rest", "in a bend"))
@pytest.mark.parametrize("limit", [Skid(0.3), TipOver(20.0)])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e4])
def test_margins_of_mirror_and_planner(limit, scale, motion):
    """Up to deviations of four hundred times the mass: neither takes a step that could be too large."""
    told, arms = estimate(covariance(scale), motion), hands()
    mirror = Mirror(cart(), {arm.name: arm for arm in arms}, [limit], None, 0.99, 1e-3)
    mirror.take_estimate(told._replace(model_parameters=mirror.phi))
    held = mirror.holds({"left": LEFT, "right": RIGHT}).cones
    rows = RobustLimits((limit,), 0.99).rows(PushedCart(cart(), motion, arms), told.covariance)
    maps = np.hstack([grasp_map_spatial(point) for point in (LEFT, RIGHT)])
    assert len(rows.cones) == len(held) > 1
    for cone, (matrix, offset) in zip(rows.cones, held, strict=True):
        ours = np.column_stack([rows.of_sum[cone.own] @ maps, cone.offset])
        theirs = np.column_stack([matrix, offset])
        assert ours[0] == pytest.approx(theirs[0], rel=1e-9, abs=1e-9)
        spread = ours[1:].T @ ours[1:]
        assert spread == pytest.approx(theirs[1:].T @ theirs[1:], rel=1e-8, abs=1e-10 * np.abs(spread).max())
