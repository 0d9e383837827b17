"""What the multipliers of one solved program say about other contacts: `planning.allocation.duality.Cut` in a form that
is affine in the contact, with the same bound. tests/planning/tick/test_compiled_planning.py compares the two.

Relax all rows with y and keep the box. The rows are affine in each arm's (x, y, z), so what is left is, arm by arm,

    phi(p) = sum_j least over the box of (w_j F_j² + r_j(p) F_j),    r = slope_0 + x slope_x + y slope_y + z slope_z,

and the bound at contacts p is `constant + sum_i phi_i(p_i)`; from a Farkas ray, with w = 0, it is a distance by which
what is asked is missed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array

from .jit import compiled
from .proof import UNLIMITED_FORCE
from .working_set import Ints
from .workspace import Workspace


class Table(NamedTuple):
    """Candidate points of all arms (V, 3), those of arm i from starts[i] to starts[i + 1]; weights of the separable
    cost (n,), and what points cost beside it, charges (V,), or none (0,); the last cut's slopes (4, n) and phi (V,);
    and a bound for each full choice (N,), the last arm's point running fastest: infinite where it is solved, infeasible
    or not allowed."""

    points: Array
    starts: Ints
    weights: Array
    charges: Array
    slopes: Array
    phi: Array
    bounds: Array


@compiled
def relax(w: Workspace, slopes: Array, share: float) -> float:
    """Adds `share` times the rows, weighed by their multipliers, to slopes; returns the constant."""
    y, rows, limits, affine = w.claim.y, w.claim.rows, w.claim.limits, w.affine
    n, first, constant = len(w.claim.x), len(w.claim.y) - w.affine.shape[1], 0.0
    for i in range(n, len(y)):
        limit = limits[1, i] if y[i] > 0.0 else limits[0, i]
        if y[i] == 0.0 or not np.isfinite(limit):
            continue
        constant -= share * y[i] * limit
        for j in range(n):
            if i < first:
                slopes[0, j] += share * y[i] * rows[i, j]
            else:
                for c in range(4):
                    slopes[c, j] += share * y[i] * affine[c, i - first, j]
    return constant


@compiled
def effort_cut(w: Workspace, table: Table) -> float:
    """From an optimum; a coupling of arms enters by its tangent there. Fills slopes and phi, returns the constant."""
    x, hessian, slopes, weights = w.claim.x, w.claim.hessian, table.slopes, table.weights
    constant = w.claim.constant[0]
    for j in range(len(x)):
        coupled = -2.0 * weights[j] * x[j]
        for i in range(len(x)):
            coupled += hessian[j, i] * x[i]
        slopes[0, j] = w.claim.gradient[j] + coupled
        constant -= 0.5 * coupled * x[j]
        for c in range(1, 4):
            slopes[c, j] = 0.0
    constant += relax(w, slopes, 1.0)
    tabulate(w, table, 1.0)
    for v in range(len(table.charges)):
        table.phi[v] += table.charges[v]
    return float(constant)


@compiled
def ray_cut(w: Workspace, table: Table) -> float:
    """From a Farkas ray, over the length of its multipliers of equalities."""
    y, square = w.claim.y, 0.0
    for i in range(len(y) - w.claim.n_equalities, len(y)):
        square += y[i] ** 2
    for c in range(4):
        for j in range(len(w.claim.x)):
            table.slopes[c, j] = 0.0
    constant = relax(w, table.slopes, 1.0 / np.sqrt(square) if square > 0.0 else 1.0)
    tabulate(w, table, 0.0)
    return constant


@compiled
def tabulate(w: Workspace, table: Table, share: float) -> None:
    """phi of all candidate points, with `share` of the weights."""
    points, starts, weights, slopes, phi = table.points, table.starts, table.weights, table.slopes, table.phi
    limits = w.claim.limits
    for arm in range(len(starts) - 1):
        for v in range(starts[arm], starts[arm + 1]):
            phi[v] = 0.0
        for j in range(6 * arm, 6 * arm + 6):
            low, high, weight = (
                max(limits[0, j], -UNLIMITED_FORCE),
                min(limits[1, j], UNLIMITED_FORCE),
                share * weights[j],
            )
            for v in range(starts[arm], starts[arm + 1]):
                slope = slopes[0, j] + points[v, 0] * slopes[1, j] + points[v, 1] * slopes[2, j]
                slope += points[v, 2] * slopes[3, j]
                at = low if slope > 0.0 else high
                if weight > 0.0:
                    at = min(max(-0.5 * slope / weight, low), high)
                phi[v] += (weight * at + slope) * at
