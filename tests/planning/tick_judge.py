"""Judges what a planner answers at a tick by what a `Mirror` says holds: HiGHS where all is linear, Clarabel with
matrices of our own where there are cones."""

from __future__ import annotations

import clarabel
import numpy as np
import pytest
from scipy import sparse
from scipy.optimize import linprog

from .mirror import apart, in_reach, within

TOLERANCE = 1e-6
GAP = 1e-8  # over the cost, at least 1: what a plan may cost more than the least, `STATIONARITY_TOLERANCE`
ROUNDING = 1e-9  # of what is asked, at least 1: by what a plan may break its rows, `EQUALITY_TOLERANCE`
TIGHT = {"primal_feasibility_tolerance": 1e-9, "dual_feasibility_tolerance": 1e-9}


def excess(holds, x):
    """By how much F breaks rows (over their length, where that is above 1) and cones."""
    broken = [0.0]
    if len(holds.rows):
        broken.append(float(((holds.rows @ x - holds.limits) / _lengths(holds.rows)).max()))
    for matrix, values in holds.cones:
        s = matrix @ x + values
        broken.append(float(np.linalg.norm(s[1:]) - s[0]) / max(1.0, float(np.linalg.norm(matrix[0]))))
    return max(broken)


def support(holds, direction):
    """The most of a direction (k,) that can be given, and None where no answer can be trusted; -inf where nothing
    can be given at all."""
    along = direction @ holds.matrix
    if holds.cones:
        return _support_over_cones(holds, along)
    found = linprog(-along, holds.rows, holds.limits, bounds=(None, None), method="highs", options=TIGHT)
    return {0: -found.fun if found.fun is not None else None, 2: -np.inf, 3: np.inf}.get(found.status)


def _support_over_cones(holds, along):
    cones = [clarabel.NonnegativeConeT(len(holds.limits))]
    cones += [clarabel.SecondOrderConeT(len(values)) for _, values in holds.cones]
    rows = sparse.csc_matrix(np.vstack([holds.rows, *(-matrix for matrix, _ in holds.cones)]))
    values = np.concatenate([holds.limits, *(values for _, values in holds.cones)])
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    nothing = sparse.csc_matrix((len(along), len(along)))
    found = clarabel.DefaultSolver(nothing, -along, rows, values, cones, settings).solve()
    status = str(found.status)
    return {"Solved": -found.obj_val, "PrimalInfeasible": -np.inf, "DualInfeasible": np.inf}.get(status)


def suboptimality(holds, cost, x, rounding=0.0):
    """By how much F may cost more than the least, over the cost, at least 1; infinite where no multipliers tell.

    For multipliers y >= 0 of all rows `R x <= l` and m of what is given, `M x`, with the residual
    `r = slope + Rᵀ y + Mᵀ m`, convexity gives for every x' that holds and gives the same

        cost(x) - cost(x') <= slope (x - x') <= y (l - R x) + r (x - x'),

    so the least `y (l - R x)` with r within tolerance proves x good. A test of r with the touched rows alone does not:
    near a degenerate corner an x that costs 1e-9 of its cost more than the least may be far from rows that hold the
    least. Rows for the worst arm's share may be broken by `rounding`, as those of a plan's limits are."""
    rows, matrix = holds.rows, holds.matrix
    slacks = holds.limits - rows @ x
    if len(cost.gradient) > len(x):
        x = np.append(x, float((cost.rows[:, :-1] @ x).max()))
        rows, matrix = (np.pad(part, ((0, 0), (0, 1))) for part in (rows, matrix))
        rows, slacks = np.vstack([rows, cost.rows]), np.concatenate([slacks, -cost.rows @ x - rounding])
    slope = cost.hessian @ x + cost.gradient
    scale = max(1.0, float(np.abs(slope).max()))
    sizes = np.abs(rows).max(axis=1)
    rows, slacks, sizes = (part[sizes > 0] for part in (rows, slacks, sizes))
    residual = np.hstack([matrix.T, (rows / sizes[:, None]).T])
    limits = TOLERANCE + np.concatenate([-slope, slope]) / scale
    bounds = [(None, None)] * len(matrix) + [(0, None)] * len(rows)
    sides, value = np.vstack([residual, -residual]), 0.5 * abs(x @ cost.hessian @ x) + abs(cost.gradient @ x)
    bound = np.inf
    for prices, presolve, size in _attempts(len(matrix), slacks / sizes):
        options = TIGHT | {"presolve": presolve}
        found = linprog(size * prices, sides, limits, bounds=bounds, method="highs", options=options)
        if found.status == 0:
            bound = min(bound, prices @ found.x * scale / max(1.0, value))
        if bound <= GAP:
            break
    return bound


def _attempts(n_given, prices):
    """Any multipliers prove, and HiGHS has missed the best. A row that is broken by rounding pays for what it takes;
    where such rows leave nothing that holds (a nearest wrench is at the edge), they count as touched, which proves as
    well."""
    for paid in (prices, np.maximum(prices, 0.0)):
        for presolve, size in ((True, 1.0), (False, 1.0), (False, 1e6)):
            yield np.concatenate([np.zeros(n_given), paid]), presolve, size


def check_contacts(mirror, given, plan, distance):
    for name, point in plan.contacts.items():
        if name in given:
            assert np.array_equal(point, np.asarray(given[name], float))
            assert in_reach(mirror.arms[name], point)
        else:
            assert within(mirror.arms[name], point), (name, point)
    assert apart(list(plan.contacts.values())) >= distance - 1e-8


def check_usable(mirror, plan, wrench, relax):
    """Within all limits; gives what is asked or the nearest to it; at least cost."""
    holds, x = mirror.holds(plan.contacts), np.concatenate([plan.wrenches[name] for name in mirror.arms])
    target = mirror.structure.constraints.basis_b.T @ np.asarray(wrench, float)
    scale = max(1.0, float(np.abs(target).max()))
    assert excess(holds, x) <= TOLERANCE * scale
    given = holds.matrix @ x
    if plan.status == "optimal":
        assert np.abs(given - target).max() <= TOLERANCE * scale
    else:
        check_nearest(holds, _effective(mirror, plan.certificate), target, given)
        assert np.linalg.norm(target - given) <= relax * (1 + 1e-9) + 1e-9
        assert list(plan.missing.values()) == pytest.approx(target - given, abs=TOLERANCE * scale)
    if not holds.cones and plan.solver != "projection":  # which is the nearest, but not at least cost
        assert suboptimality(holds, mirror.cost(), x, ROUNDING * scale) <= GAP, (plan.status, plan.solver)


def check_nearest(holds, normal, target, given):
    """No point of a convex set is nearer than the set's support along any direction says: one comes close to it."""
    distance, scale = float(np.linalg.norm(target - given)), max(1.0, float(np.abs(target).max()))
    normals = ((target - given) / max(distance, 1e-300), normal)
    found = [(n @ target - most) for n in normals if (most := support(holds, n)) is not None]
    assert not found or distance <= max(found) + TOLERANCE * scale, (distance, found)


def check_infeasible(mirror, plan, wrench, relax, given):
    """A certificate with a direction is right by what can be given along it; one without by its distance, its reach,
    or by limits that nothing keeps."""
    certificate, target = plan.certificate, mirror.structure.constraints.basis_b.T @ np.asarray(wrench, float)
    scale = max(1.0, float(np.abs(target).max()))
    assert plan.message == certificate.words
    if not certificate.direction:
        if "reach" in plan.message:
            assert not all(in_reach(mirror.arms[name], np.asarray(point, float)) for name, point in given.items())
        elif "min_hand_distance" not in plan.message:
            points = {name: given.get(name, arm.contacts.first) for name, arm in mirror.arms.items()}
            holds = mirror.holds(points)
            assert support(holds, np.zeros(len(target))) in (None, -np.inf)
        return
    assert certificate.verified
    nearest = plan.nearest
    holds, x = mirror.holds(nearest.contacts), np.concatenate([nearest.wrenches[name] for name in mirror.arms])
    normal = _effective(mirror, certificate)
    most = support(holds, normal)
    assert certificate.asked == pytest.approx(normal @ target, abs=1e-9 * scale)
    if most is not None:
        assert normal @ target > most - 1e-8 * scale
        assert certificate.most >= most - TOLERANCE * scale
    if nearest.solution.residuals.feasible:
        assert excess(holds, x) <= TOLERANCE * scale
        reached = holds.matrix @ x
        check_nearest(holds, normal, target, reached)
        assert np.linalg.norm(target - reached) > relax - TOLERANCE * scale


def _effective(mirror, certificate):
    basis = mirror.structure.constraints.basis_b
    return np.linalg.lstsq(basis, np.asarray(certificate.direction), rcond=None)[0]


def _lengths(rows):
    return np.maximum(1.0, np.linalg.norm(rows, axis=1))
