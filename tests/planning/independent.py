"""Judges of a plan that know nothing of `planning`: limits, equality, KKT and Farkas, from `drawn` alone.

A plan shows no multipliers, so the judge looks for them: at a minimum the cost's slope is a combination of the
equality's rows and, with weights >= 0, of the normals of the limits that are touched. Non-negative least squares
finds the best one; what it leaves over is the stationarity residual.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog, nnls

from cartgrasp.friction import EXACT

from .drawn import effective_matrix, linear_limits, replace_friction

TOUCHED = 1e-6
GENERATORS, REFINEMENTS = 24, 12  # of the normals around a friction cone


class Judged(NamedTuple):
    """Residuals over the scale of the wrench asked for (equality, limits) or of the cost's slope, at least 1."""

    equality: float
    limits: float
    stationarity: float


def judge(model, arms, contacts, wrench, wrenches):
    """Judges wrenches (6,) by arm, at contacts (3,) by arm, for a wrench (3,) on the cart."""
    x = np.concatenate([wrenches[a.name] for a in arms])
    matrix, target = effective_matrix(model, arms, contacts), model.constraints.basis_b.T @ np.asarray(wrench, float)
    scale = max(1.0, float(np.abs(target).max()))
    normals, slacks = _limits(arms, x)
    cone_normals, cone_slacks, around = _cones(arms, x, TOUCHED * scale)
    slope = 2 * np.concatenate([a.weights for a in arms]) * x
    length = np.maximum(1.0, np.linalg.norm(normals, axis=1))  # a lever of 1e7 m makes a slack of what is no distance
    touched = np.vstack([(normals / length[:, None])[slacks / length <= TOUCHED * scale], cone_normals])
    left = _left_over(slope, matrix, touched, around) if np.any(slope) else 0.0
    return Judged(
        float(np.abs(matrix @ x - target).max()) / scale,
        max(0.0, -float(min([*slacks, *cone_slacks], default=0.0))) / scale,
        left / max(1.0, float(np.abs(slope).max())),
    )


def farkas_margin(model, arms, contacts, wrench, direction):
    """By how much more is asked along a direction of (fx, fy, tau) than weak duality allows, in plain numpy. The
    limits' multipliers come from HiGHS, but whatever they are the bound is valid: positive proves infeasibility."""
    rows, limits, bounds = linear_limits(arms)
    direction = np.asarray(direction)
    free, *_ = np.linalg.lstsq(model.constraints.basis_b, direction, rcond=None)
    along = free @ effective_matrix(model, arms, contacts)
    lower = np.array([-1e6 if low is None else low for low, _ in bounds])
    upper = np.array([1e6 if high is None else high for _, high in bounds])
    box = list(zip(lower, upper, strict=True))
    found = linprog(-along, rows if len(rows) else None, limits if len(rows) else None, bounds=box, method="highs")
    multipliers = np.maximum(-found.ineqlin.marginals, 0.0) if len(rows) else np.zeros(0)
    rest = along - multipliers @ rows
    most = multipliers @ limits + np.maximum(rest * lower, rest * upper).sum()
    return float(free @ model.constraints.basis_b.T @ np.asarray(wrench, float) - most)


def without_cones(arms):
    """Arms as `linear_limits` can take them: a cone is left out."""
    return [replace_friction(a, None) if _has_cone(a) else a for a in arms]


def _has_cone(a):
    return a.friction is not None and a.friction.sides == EXACT


def _limits(arms, x):
    """Outward normals of the linear limits, and how far x is from each."""
    rows, limits, bounds = linear_limits(without_cones(arms))
    normals, slacks = [*rows], [*(limits - rows @ x)]
    for axis, (low, high) in zip(np.eye(len(x)), bounds, strict=True):
        for sign, bound in ((-1.0, low), (1.0, high)):
            if bound is not None:
                normals.append(sign * axis)
                slacks.append(sign * (bound - axis @ x))
    return np.array(normals).reshape(len(normals), len(x)), np.array(slacks)


def _cones(arms, x, touched):
    """Normals of friction cones that are touched where they are smooth, slacks of all, and the others as (start,
    mu): at the apex, or so thin that they are touched all around."""
    normals, slacks, around = [], [], []
    for i, a in enumerate(arms):
        if not _has_cone(a):
            continue
        fx, fy, fz = x[6 * i : 6 * i + 3]
        mu, across = a.friction.mu, np.hypot(fy, fz)
        slacks += [mu * fx - across, fx]
        if fx <= touched:
            normals.append(-np.eye(len(x))[6 * i])
        if max(mu * fx, across) <= touched:
            around.append((6 * i, mu))
        elif slacks[-2] <= touched:
            normals.append(_cone_normal(len(x), 6 * i, mu, np.arctan2(fz, fy)))
    return np.array(normals).reshape(len(normals), len(x)), slacks, around


def _cone_normal(n, start, mu, angle):
    normal = np.zeros(n)
    normal[start : start + 3] = -mu, np.cos(angle), np.sin(angle)
    return normal


def _left_over(slope, matrix, touched, around):
    """The smallest slope that no multipliers explain. Around a cone the generators are made denser, step by step,
    where they carry weight."""
    n, width = len(slope), 2 * np.pi / GENERATORS
    fixed = [*matrix, *-matrix, *touched]
    angles = [width * np.arange(GENERATORS) for _ in around]
    for step in range(REFINEMENTS if around else 1):
        basis = [*fixed]
        for (start, mu), some in zip(around, angles, strict=True):
            basis += [_cone_normal(n, start, mu, angle) for angle in some]
        basis = np.array(basis)
        longest = np.abs(basis).max(axis=1, keepdims=True)
        basis = basis / np.where(longest > 0, longest, 1.0)
        weights, _ = nnls(basis.T, -slope, maxiter=100 * len(basis))
        rest, first = slope + weights @ basis, len(fixed)
        for k, ((start, _), some) in enumerate(zip(around, angles, strict=True)):
            _, y, z = (weights[first : first + len(some)] @ basis[first : first + len(some)])[start : start + 3]
            first += len(some)
            near = np.arctan2(z, y) + width / 2**step * np.array([-0.5, 0.0, 0.5])
            angles[k] = np.concatenate([some, near])
    return float(np.abs(rest).max())
