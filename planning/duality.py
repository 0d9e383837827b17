"""Weak duality over contacts: what one solved program says about every other choice of contacts.

Relax the effective rows with multipliers mu (k,) and the limits' rows and cones with theirs (which bound `l F
<= sigma` for all F within limits); keep the box. What is left falls apart into scalars, and each into arms:

    bound(contacts) = constant + sum_i phi_i(p_i),
    phi_i(p) = sum_j min over the box of (w_j F_j² + r_j F_j),    r = linear + mu (Sᵀ G_i(p)).

r is affine in p, so phi_i is concave: over a segment its least value is at an end. With w = 0 and linear = l
it is a Farkas ray: where its bound is above zero, no wrench within limits gives what is asked. Any
multipliers of the right sign give a valid bound, however inexact the solver; axes without a limit count as
limited to `UNLIMITED`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array

from .allocation_template import AllocationTemplate
from .objectives import Cost
from .quadratic_program import QPSolution, QuadraticProgram, into_cone

UNLIMITED = 1e6


@dataclass(frozen=True, eq=False)
class Cut:
    """A bound over contacts; weights, linear, lower and upper are (n, 6)."""

    weights: Array
    linear: Array
    lower: Array
    upper: Array
    multipliers: Array
    constant: float
    ray: bool = False

    def per_vertex(self, rows: Array, arm: Array) -> Array:
        """phi of candidate points with rows (V, k, 6) that belong to arms (V,), shape (V,)."""
        slope = self.linear[arm] + self.multipliers @ rows
        return _least(self.weights[arm], slope, self.lower[arm], self.upper[arm])

    def value(self, rows: Array) -> Array:
        """The bound at full choices of contacts with rows (..., n, k, 6), shape (...)."""
        slope = self.linear + self.multipliers @ rows
        return np.asarray(self.constant + _least(self.weights, slope, self.lower, self.upper).sum(axis=-1))

    @property
    def looks_low(self) -> bool:
        """Whether a range of contacts is bounded at its low vertex; else at the high one. None moves it:
        either."""
        return bool(self.multipliers[-1] >= 0)


def effort_cut(
    template: AllocationTemplate, solution: QPSolution, multipliers: Array, target: Array, cost: Cost
) -> Cut:
    """From a solved allocation; a coupling of arms enters by its tangent at the solution, which is below
    it."""
    linear, sigma = _relaxed_limits(template, solution)
    linear, constant = linear + cost.gradient, cost.constant - sigma - float(multipliers @ target)
    if cost.coupling is not None:
        x = solution.x[: template.n]
        slope = cost.coupling @ x
        linear, constant = linear + 2.0 * slope, constant - float(x @ slope)
    return _cut(template, (cost.weights, linear), multipliers, constant, False)


def distance_cut(template: AllocationTemplate, solution: QPSolution, slack: Array, target: Array) -> Cut:
    """From a solved projection: bounds ½ distance² over contacts."""
    linear, sigma = _relaxed_limits(template, solution)
    constant = float(slack @ target) - sigma - 0.5 * float(slack @ slack)
    return _cut(template, (np.zeros(template.n), linear), -slack, constant, False)


def farkas_cut(template: AllocationTemplate, solution: QPSolution, slack: Array, target: Array) -> Cut:
    """From a solved projection: a ray whose value is the distance at least where it is positive."""
    linear, sigma = _relaxed_limits(template, solution)
    length = float(np.linalg.norm(slack))
    constant = (float(slack @ target) - sigma) / length
    return _cut(template, (np.zeros(template.n), linear / length), -slack / length, constant, True)


def infeasible_by(program: QuadraticProgram, solution: QPSolution, slack: Array) -> float:
    """A distance that a program's equalities are missed by at least, from its projection's `solution`:
    positive proves the program infeasible. Other than a cut, it weighs the two rows of a range one by one."""
    n, start = program.n, len(solution.x)
    y = solution.multipliers[start:]
    lower, upper = program.lower[n:], program.upper[n:]
    limits = np.where(y > 0, upper, lower)
    held = (y != 0) & np.isfinite(limits)
    linear = y[held] @ program.rows[held]
    constant = -float(y[held] @ limits[held])
    for cone, z in zip(program.cones, solution.cone_multipliers, strict=True):
        inside = into_cone(z)
        linear, constant = linear - inside @ cone.rows, constant - float(inside @ cone.offset)
    box = (np.maximum(program.lower[:n], -UNLIMITED), np.minimum(program.upper[:n], UNLIMITED))
    return (constant + float(_least(np.zeros(n), linear, *box))) / float(np.linalg.norm(slack))


def _cut(
    template: AllocationTemplate, scalars: tuple[Array, Array], multipliers: Array, constant: float, ray: bool
) -> Cut:
    shape = (len(template.arms), 6)
    lower = np.maximum(template.limits.lower, -UNLIMITED).reshape(shape)
    upper = np.minimum(template.limits.upper, UNLIMITED).reshape(shape)
    weights, linear = (part.reshape(shape) for part in scalars)
    return Cut(weights, linear, lower, upper, multipliers, constant, ray)


def _relaxed_limits(template: AllocationTemplate, solution: QPSolution) -> tuple[Array, float]:
    """l (6n,) and sigma with `l @ F <= sigma` for every F within the rows and cones of the limits."""
    limits, start = template.limits, len(solution.x)
    dual = np.maximum(solution.multipliers[start : start + len(limits.limits)], 0.0)
    linear, sigma = dual @ limits.rows, float(dual @ limits.limits)
    for cone, z in zip(limits.cones, solution.cone_multipliers, strict=True):
        inside = into_cone(z)
        linear, sigma = linear - inside @ cone.rows, sigma + float(inside @ cone.offset)
    return linear, sigma


def _least(weights: Array, slope: Array, lower: Array, upper: Array) -> Array:
    """Sum over the last axis of the least `w F² + r F` over a box."""
    curved = weights > 0
    free = -0.5 * slope / np.where(curved, weights, 1.0)
    at = np.where(curved, np.clip(free, lower, upper), np.where(slope > 0, lower, upper))
    return np.asarray(((weights * at + slope) * at).sum(axis=-1))
