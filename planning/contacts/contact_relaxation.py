"""The convex relaxation of contact choice, in cvxpy: each arm holds a mixture of its candidates.

Arm i holds candidate c to a share z_ic >= 0, sum_c z_ic = 1, with a wrench F_ic within z_ic times its limits:

    minimise    sum_ic  sum_j w_ij F_icj² / z_ic        (the perspective of the effort)
    such that   sum_ic A_i(c) F_ic = Sᵀ wrench_b        (and the cart's limits)

One candidate at full share is such a mixture, so the value bounds every choice from below; so is a point within a
segment a mixture of its ends. It is exact where every arm ends with one share. `WrenchPlanner` chooses exactly and
faster; this is what a convex modelling layer can say, and an independent bound for its tests. The least distance
between hands is left out.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.arms import Arm
from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..allocation.allocation_template import AllocationTemplate
from ..limits import CartLimit, LimitRows, limits_of
from ..quadratic_program import NUMERICAL
from .contact_bounds import Candidates

RELAXATION_TOLERANCE = 1e-8


@dataclass(frozen=True, eq=False)
class ContactRelaxation:
    """cvxpy's status (`numerical` where its solver fails); no choice of contacts costs less than `bound` (infinite when
    infeasible), to 1e-6 of it, or 1e-3 where the status ends with `inaccurate` (shares near zero); the shares (c,) of
    each arm's points and then ends of segments."""

    status: str
    bound: float
    shares: Mapping[str, Array]

    def gap(self, cost: float) -> float:
        """The optimality gap of a choice with this `cost`, relative to max(1, |cost|)."""
        return (cost - self.bound) / max(1.0, abs(cost))


def relax_contact_choice(
    cart: CartModel, arms: Sequence[Arm], wrench_b: ArrayLike, cart_limits: Sequence[CartLimit] = ()
) -> ContactRelaxation:
    """Solves the relaxation for the effort `sum w F²` and a cart at rest."""
    import cvxpy

    template = AllocationTemplate.of(cart, arms, cart_limits=cart_limits)
    target = template.basis_b.T @ np.asarray(wrench_b, dtype=float)
    unit = max(1.0, float(np.abs(target).max()))  # N, N·m: unknowns are of the order of 1
    given: Any = 0.0
    effort: Any = 0.0
    held: list[Any] = []
    constraints: list[Any] = []
    for i, arm in enumerate(template.arms):
        points = Candidates.of([arm.contacts]).vertices
        rows = template.contact_rows(points, np.full(len(points), i))
        limits, root = limits_of(arm), np.sqrt(arm.weights)
        share = cvxpy.Variable(len(points), nonneg=True)
        constraints.append(cvxpy.sum(share) == 1)
        held.append(share)
        for c in range(len(points)):
            wrench = cvxpy.Variable(6)
            given = given + rows[c] @ wrench
            effort = effort + cvxpy.quad_over_lin(cvxpy.multiply(root, wrench), share[c])
            constraints += _within(limits, wrench, share[c], unit)
    low, high = template.contact_limits(target)
    constraints += _between(given, low / unit, high / unit, 1.0)
    problem = cvxpy.Problem(cvxpy.Minimize(effort), constraints)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the status says `optimal_inaccurate` then
        try:
            problem.solve(
                solver=cvxpy.CLARABEL, **dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), RELAXATION_TOLERANCE)
            )
        except cvxpy.SolverError:
            return ContactRelaxation(NUMERICAL, -np.inf, {})
    status = str(problem.status)
    if status not in ("optimal", "optimal_inaccurate"):
        return ContactRelaxation(status, np.inf if status.startswith("infeasible") else -np.inf, {})
    shares = {arm.name: np.asarray(share.value) for arm, share in zip(template.arms, held, strict=True)}
    return ContactRelaxation(status, unit**2 * float(problem.value), shares)


def _within(limits: LimitRows, wrench: Any, share: Any, unit: float) -> list[Any]:
    """The wrench, in units of `unit`, in `share` times the limits."""
    import cvxpy

    constraints = _between(wrench, limits.lower / unit, limits.upper / unit, share)
    if len(limits.rows):
        constraints += _between(limits.rows @ wrench, limits.low_limits / unit, limits.limits / unit, share)
    for cone in limits.cones:
        s = cone.offset / unit * share + cone.rows @ wrench
        constraints.append(cvxpy.SOC(s[0], s[1:]))
    return constraints


def _between(value: Any, low: Array, high: Array, share: Any) -> list[Any]:
    """low <= value <= high; as one equality where the two are the same."""
    constraints = []
    equal = np.flatnonzero(low == high)
    if len(equal):
        constraints.append(value[equal] == low[equal] * share)
    for limit, sign in ((high, 1.0), (low, -1.0)):
        finite = np.flatnonzero(np.isfinite(limit) & (low != high))
        if len(finite):
            constraints.append(sign * value[finite] <= sign * limit[finite] * share)
    return constraints
