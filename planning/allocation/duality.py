"""Weak duality over contacts: what one solved program says about every other choice of contacts.

Relax the rows that depend on contacts (the cart's limits, and the effective rows) with multipliers mu (c + k,) and
the limits' rows and cones with theirs (which bound `l F <= sigma` for all F within limits); keep the box. What is
left falls apart into scalars, and each into arms:

    bound(contacts) = constant + sum_i phi_i(p_i),
    phi_i(p) = sum_j min over the box of (w_j F_j² + r_j F_j),    r = linear + mu (contact rows of i at p).

r is affine in p, so phi_i is concave: over a segment its least value is at an end. With w = 0 and linear = l
it is a Farkas ray: where its bound is above zero, no wrench within limits gives what is asked. Any
multipliers of the right sign give a valid bound, however inexact the solver; axes without a limit count as
limited to `UNLIMITED_FORCE`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array

from ..objectives import Cost
from ..quadratic_program import QPSolution, QuadraticProgram, into_cone
from .allocation_template import AllocationTemplate

UNLIMITED_FORCE = 1e6
MIN_WEIGHT = 1e-100  # a weight below is none: over UNLIMITED_FORCE it is worth nothing, and dividing by it overflows


@dataclass(frozen=True, eq=False)
class Cut:
    """A bound over contacts; weights, linear, lower and upper are (n, 6), multipliers (c + k,)."""

    weights: Array
    linear: Array
    lower: Array
    upper: Array
    multipliers: Array
    constant: float
    ray: bool = False

    def per_vertex(self, rows: Array, arm: Array) -> Array:
        """phi of candidate points with rows (V, c + k, 6) that belong to arms (V,), shape (V,)."""
        slope = self.linear[arm] + self.multipliers @ rows
        return _least(self.weights[arm], slope, self.lower[arm], self.upper[arm])

    def value(self, rows: Array) -> Array:
        """The bound at full choices of contacts with rows (..., n, c + k, 6), shape (...)."""
        slope = self.linear + self.multipliers @ rows
        return np.asarray(self.constant + _least(self.weights, slope, self.lower, self.upper).sum(axis=-1))

    @property
    def looks_low(self) -> bool:
        """Whether the moment over a range of contacts is bounded at its low vertex; else at the high one. None moves
        it: either."""
        return bool(self.multipliers[-1] >= 0)


def effort_cut(
    template: AllocationTemplate, solution: QPSolution, multipliers: Array, target: Array, cost: Cost
) -> Cut:
    """From a solved allocation and its multipliers of the contact rows; a coupling of arms enters by its tangent
    at the solution, which is below it."""
    linear, sigma = _relaxed_limits(template, solution)
    tangent, constant = _by_tangent(cost, solution.x)
    return _cut(template, (cost.weights, linear + tangent), multipliers, constant - sigma, target)


def least_cost(template: AllocationTemplate, cost: Cost) -> float:
    """What nothing within the box costs less than, whatever is asked and wherever hands hold: a cut without multipliers
    and with its tangent at the cost's own least. That of a sum of squares is zero at least, but for rounding."""
    curved = np.diag(cost.weights) if cost.coupling is None else np.diag(cost.weights) + cost.coupling
    least = -0.5 * np.asarray(np.linalg.lstsq(curved, cost.gradient)[0], dtype=float)
    linear, constant = _by_tangent(cost, least)
    lower, upper = np.maximum(template.fixed.lower, -UNLIMITED_FORCE), np.minimum(template.fixed.upper, UNLIMITED_FORCE)
    return constant + float(_least(cost.weights, linear, lower, upper))


def distance_cut(template: AllocationTemplate, solution: QPSolution, slack: Array, target: Array) -> Cut:
    """From a solved projection: bounds ½ distance² over contacts."""
    linear, sigma = _relaxed_limits(template, solution)
    multipliers = np.concatenate([of_cart(template, solution), -slack])
    constant = -sigma - 0.5 * float(slack @ slack)
    return _cut(template, (np.zeros(len(linear)), linear), multipliers, constant, target)


def farkas_cut(template: AllocationTemplate, solution: QPSolution, slack: Array, target: Array) -> Cut:
    """From a solved projection: a ray whose value is the distance at least where it is positive."""
    linear, sigma = _relaxed_limits(template, solution)
    length = float(np.linalg.norm(slack))
    multipliers = np.concatenate([of_cart(template, solution), -slack]) / length
    cut = _cut(template, (np.zeros(len(linear)), linear / length), multipliers, -sigma / length, target)
    return replace(cut, ray=True)


def infeasible_by(program: QuadraticProgram, solution: QPSolution, slack: Array) -> float:
    """A distance that a program's equalities are missed by at least, from its projection's `solution`:
    positive proves the program infeasible. Other than a cut, it weighs the two rows of a range one by one."""
    n = program.n
    y, sigma = _priced(solution.multipliers[len(solution.x) :], program.lower[n:], program.upper[n:])
    linear = y @ program.rows
    for cone, z in zip(program.cones, solution.cone_multipliers, strict=True):
        inside = into_cone(z)
        linear, sigma = linear - inside @ cone.rows, sigma + float(inside @ cone.offset)
    box = (np.maximum(program.lower[:n], -UNLIMITED_FORCE), np.minimum(program.upper[:n], UNLIMITED_FORCE))
    return (float(_least(np.zeros(n), linear, *box)) - sigma) / float(np.linalg.norm(slack))


def _cut(
    template: AllocationTemplate, scalars: tuple[Array, Array], multipliers: Array, constant: float, target: Array
) -> Cut:
    """Relaxes the contact rows as well; unknowns beside the wrenches are minimised over here and now."""
    multipliers, limit = _priced(multipliers, *_contact_limits(template, target))
    n, (weights, linear), fixed = template.n, scalars, template.fixed
    lower, upper = np.maximum(fixed.lower, -UNLIMITED_FORCE), np.minimum(fixed.upper, UNLIMITED_FORCE)
    own = float(_least(weights[n:], linear[n:], lower[n:], upper[n:]))
    weights, linear, lower, upper = (part[:n].reshape(-1, 6) for part in (weights, linear, lower, upper))
    return Cut(weights, linear, lower, upper, multipliers, constant - limit + own)


def _by_tangent(cost: Cost, x: Array) -> tuple[Array, float]:
    """Linear part and constant of a cost whose coupling is replaced by its tangent at x, which is below it."""
    if cost.coupling is None:
        return cost.gradient, cost.constant
    slope = cost.coupling @ x
    return cost.gradient + 2.0 * slope, cost.constant - float(x @ slope)


def _relaxed_limits(template: AllocationTemplate, solution: QPSolution) -> tuple[Array, float]:
    """l (unknowns,) and sigma with `l @ x <= sigma` for every x within the rows and cones of the limits."""
    fixed, start = template.fixed, len(solution.x)
    priced = solution.multipliers[start : start + len(fixed.limits)]
    dual, sigma = _priced(priced, fixed.low_limits, fixed.limits)
    linear = dual @ fixed.rows
    for cone, z in zip(fixed.cones, solution.cone_multipliers[: len(fixed.cones)], strict=True):
        inside = into_cone(z)
        linear, sigma = linear - inside @ cone.rows, sigma + float(inside @ cone.offset)
    return linear, sigma


def of_cart(template: AllocationTemplate, solution: QPSolution) -> Array:
    """Multipliers of the cart's limits (c,); of a cone's rows they are its own, z, turned about."""
    start = len(solution.x) + len(template.fixed.limits)
    multipliers = solution.multipliers[start : start + len(template.cart_rows.low)].copy()
    for cone, z in zip(template.cart_rows.cones, solution.cone_multipliers[len(template.fixed.cones) :], strict=True):
        multipliers[cone.own] = -into_cone(z)
    return multipliers


def _contact_limits(template: AllocationTemplate, target: Array) -> tuple[Array, Array]:
    """As the template's; to -z a cone's rows v are limited by its offset: z · (offset + v) >= 0."""
    low, high = template.contact_limits(target)
    for cone in template.cart_rows.cones:
        low[cone.own] = high[cone.own] = -cone.offset
    return low, high


def _priced(multipliers: Array, low: Array, high: Array) -> tuple[Array, float]:
    """Multipliers without those of limits that aren't there, and s with `multipliers @ v <= s` for low <= v <= high."""
    at = np.where(multipliers > 0, high, low)
    held = np.isfinite(at) & (multipliers != 0)
    multipliers = np.where(held, multipliers, 0.0)
    return multipliers, float(multipliers[held] @ at[held])


def _least(weights: Array, slope: Array, lower: Array, upper: Array) -> Array:
    """Sum over the last axis of the least `w F² + r F` over a box."""
    curved = weights > MIN_WEIGHT
    free = -0.5 * slope / np.where(curved, weights, 1.0)
    at = np.where(curved, np.clip(free, lower, upper), np.where(slope > 0, lower, upper))
    return np.asarray(((weights * at + slope) * at).sum(axis=-1))
