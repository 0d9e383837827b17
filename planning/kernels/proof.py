"""Residuals of the KKT conditions, as `planning.quadratic_program.verify` has them, and the value of a Farkas ray, as
`planning.allocation.duality.infeasible_by` has it: from H, f, G and the limits alone, apart from all that a solver has
made of them. Both mirror numpy code, which stays the reference: tests/planning/kernels/test_kernel_proof.py."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array

from .jit import compiled

EQUALITY, LIMITS, STATIONARITY, GAP, COST, WRENCH_SCALE, SLOPE_SCALE = range(7)  # of Residuals
EQUALITY_TOLERANCE, STATIONARITY_TOLERANCE = 1e-9, 1e-8
UNLIMITED_FORCE = 1e6


class Claim(NamedTuple):
    """H (n, n), f (n,), constant (1,), G (n + m, n), limits (2, n + m) and how many of the last are equalities; x
    and y; and scratch (n,)."""

    hessian: Array
    gradient: Array
    constant: Array
    rows: Array
    limits: Array
    n_equalities: int
    x: Array
    y: Array
    slope: Array


@compiled
def higher(a: float, b: float) -> float:
    """The larger one; NaN if one is."""
    return a if a >= b or a != a else b


@compiled
def verify(claim: Claim, found: Array) -> bool:
    """Fills `found` (7,) in the order of `Residuals`, and says whether they prove the claim."""
    x, y, slope, constant = claim.x, claim.y, claim.slope, claim.constant[0]
    hessian, gradient, rows = claim.hessian, claim.gradient, claim.rows
    for i in range(7):
        found[i] = 0.0
    cost, largest = constant, 1.0
    for i in range(len(x)):
        curved = 0.0
        for j in range(len(x)):
            curved += hessian[i, j] * x[j]
        slope[i] = curved + gradient[i]
        cost += x[i] * (0.5 * curved + gradient[i])
        largest = higher(largest, abs(slope[i]))
    found[COST], found[WRENCH_SCALE], found[SLOPE_SCALE] = cost, wrench_scale(claim), largest
    for i in range(len(y)):
        value = 0.0
        for j in range(len(x)):
            value += rows[i, j] * x[j]
        dual = meet(claim, i, value, found)
        if dual != 0.0:
            for j in range(len(x)):
                slope[j] += dual * rows[i, j]
    for j in range(len(x)):
        found[STATIONARITY] = higher(found[STATIONARITY], abs(slope[j]))
    found[GAP] /= higher(1.0, abs(cost))
    feasible = EQUALITY_TOLERANCE * found[WRENCH_SCALE]
    kept = found[EQUALITY] <= feasible and found[LIMITS] <= feasible
    flat = found[STATIONARITY] <= STATIONARITY_TOLERANCE * largest
    return bool(kept and flat and found[GAP] <= STATIONARITY_TOLERANCE)


@compiled
def meet(claim: Claim, i: int, value: float, found: Array) -> float:
    """Counts how G_i x = value meets limit i; returns its multiplier, 0 where there is no limit for it to push from."""
    above, below, dual = claim.limits[1, i] - value, value - claim.limits[0, i], claim.y[i]
    if i >= len(claim.y) - claim.n_equalities:
        found[EQUALITY] = higher(found[EQUALITY], abs(above))
    else:
        found[LIMITS] = higher(found[LIMITS], higher(-above, -below))
    if dual == 0.0:
        return 0.0
    slack = above if dual > 0.0 else below
    if slack == np.inf:
        return 0.0
    found[GAP] += abs(dual * slack)
    return float(dual)


@compiled
def ray_value(claim: Claim) -> float:
    """By how much the limits' rows contradict each other, weighed by y: positive if no x within bounds meets them.
    Each equality counts with the length of their multipliers, so it is a distance that they are missed by."""
    x, y, rows, limits, slope = claim.x, claim.y, claim.rows, claim.limits, claim.slope
    value, square, n = 0.0, 0.0, len(x)
    for j in range(n):
        slope[j] = 0.0
    for i in range(n, len(y)):
        limit = limits[1, i] if y[i] > 0.0 else limits[0, i]
        if y[i] == 0.0 or not np.isfinite(limit):
            continue
        value -= y[i] * limit
        if i >= len(y) - claim.n_equalities:
            square += y[i] ** 2
        for j in range(n):
            slope[j] += y[i] * rows[i, j]
    for j in range(n):
        at = max(limits[0, j], -UNLIMITED_FORCE) if slope[j] > 0.0 else min(limits[1, j], UNLIMITED_FORCE)
        value += slope[j] * at
    return value / np.sqrt(square) if square > 0.0 else value


@compiled
def wrench_scale(claim: Claim) -> float:
    """The largest value of an equality, at least 1."""
    largest = 1.0
    for i in range(len(claim.y) - claim.n_equalities, len(claim.y)):
        largest = max(largest, abs(claim.limits[1, i]))
    return largest
