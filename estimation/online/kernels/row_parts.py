"""Parts of `filtered_row.py`'s algebra: what noise in a row's slopes does, and what a row's own noise is."""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.kernels.workspace import N_PHI

from .correction import eliminate
from .jit import Indices, row_compiled, row_entry

SPACING = 0.1
"""s from row to row."""
STILL = 3.0
"""Standard deviations of nu within which a cart may stand still, or be as fast as asked."""
FLOOR_SHARE = 0.002
"""Of the wrench: what a model leaves out."""
STANDS_OUT = 2.0
"""Standard deviations of B[nu'], and of nu, that teach nothing."""
NOISE_SHARE = 0.9
"""Of the variance of B[nu']: what is noise of sensors, and not motion that was smoothed away; down to a half where
there are poor poses alone."""

Rising = tuple[Array, Array, Array, Array]
"""B[nu'] (f,), with covariance (f, f); the part of it that stands out of its noise, with derivative (f,)."""


@row_entry
def slowed(velocity: Array, covariance: Array) -> Array:
    """The slowest (n, f) that each nu may be."""
    return slowest(velocity, covariance)


@row_compiled
def slowest(velocity: Array, covariance: Array) -> Array:
    n, f = velocity.shape
    slow = np.empty((n, f))
    for i in range(n):
        for a in range(f):
            left = max(abs(velocity[i, a]) - STILL * math.sqrt(covariance[i, a, a]), 0.0)
            slow[i, a] = math.copysign(left, velocity[i, a]) if left > 0.0 else 0.0
    return slow


@row_entry
def largest(theta: Array, covariance: Array) -> Array:
    return at_most(theta, covariance)


@row_compiled
def at_most(theta: Array, covariance: Array) -> Array:
    """Parameters (p,), with effects as large as they are known to be."""
    most = theta.copy()
    for q in range(N_PHI, len(theta)):
        most[q] += math.sqrt(max(covariance[q, q], 0.0))
    return most


@row_compiled
def rise_of(whole: Array, covariance: Array) -> Rising:
    part, derivative = np.zeros(len(whole)), np.zeros(len(whole))
    for a in range(len(whole)):
        square = STANDS_OUT**2 * covariance[a, a] / max(whole[a] ** 2, 1e-300)
        if square < 1.0:
            part[a], derivative[a] = (1.0 - square) * whole[a], 1.0 + square
    return whole, covariance, part, derivative


@row_compiled
def feigned_by(rise: Rising, by_acceleration: Array, mass: Array, noise: Array) -> Array:
    """(p,), from the slopes' partials by B[nu'] (f, f, p), the mass matrix and the rest of a row's noise (f, f)."""
    _, covariance, _, derivative = rise
    f, p = by_acceleration.shape[1:]
    through, beside, pull = np.zeros((f, f)), noise.copy(), np.zeros(p)
    for a in range(f):
        for b in range(f):
            for c in range(f):
                through[b, a] += derivative[a] * covariance[a, c] * mass[b, c]
    for a in range(f):
        for b in range(f):
            for c in range(f):
                for d in range(f):
                    beside[a, b] += mass[a, c] * covariance[c, d] * mass[b, d]
    eliminate(beside, through)
    for a in range(f):
        for b in range(f):
            for q in range(p):
                pull[q] -= NOISE_SHARE * through[b, a] * by_acceleration[a, b, q]
    return pull


@row_compiled
def noise_of_wrenches(held: Array, wrenches: Array, f: int) -> Array:
    """Noise of sensors, a sample that stands for several moments counted whole."""
    n, total, share = len(wrenches), np.zeros((f, f)), 0.0
    for i in range(n):
        share += held[i]
        if i + 1 == n or wrenches[i + 1, 0] != wrenches[i, 0]:
            for a in range(f):
                for b in range(f):
                    total[a, b] += share**2 * wrenches[i, 1 + f + f * a + b]
            share = 0.0
    return total


@row_compiled
def add_left_out(linear: Array, stuck: Array, of_memory: Array, noise: Array) -> None:
    """What a model leaves out of memories, and of Coulomb forces where the cart may stand still, for all that nu tells:
    they take whatever value holds it."""
    n, f, count = stuck.shape
    total = np.empty(f)
    for c in range(count + 1):
        total[:] = 0.0
        for a in range(f):
            for i in range(n):
                total[a] += linear[i] * stuck[i, a, c] if c < count else 0.0
            total[a] += of_memory[a] if c == count else 0.0
        for a in range(f):
            for b in range(f):
                noise[a, b] += total[a] * total[b] / (SPACING if c < count else 1.0)


@row_compiled
def add_measured(held: Array, wrenches: Array, theta: Array, found: tuple[Array, Array, Array]) -> None:
    """B of the wrenches to the residual, its partials off the slopes, a share of its size to the noise."""
    residual, slopes, noise = found
    f, p = len(residual), len(theta)
    first = 1 + f + f * f
    for a in range(f):
        size = 0.0
        for i in range(len(held)):
            residual[a] += held[i] * wrenches[i, 1 + a]
            size += held[i] * abs(wrenches[i, 1 + a])
            for q in range(p):
                by = held[i] * wrenches[i, first + p * a + q]
                if by != 0.0:
                    residual[a] += by * (theta[q] - wrenches[i, first + f * p + q])
                    slopes[a, q] -= by
        noise[a, a] += (FLOOR_SHARE * size) ** 2 + 1e-10


@row_compiled
def curvature_of(by: Array, spread: Array, scaled: tuple[Indices, float], gain: float) -> tuple[Array, Array]:
    """Mean (f,) and covariance (f, f) of what a row that is linear in the parameters leaves out, from partials
    (1 + q, f, p) around them and at each column of `spread` (p, q) from them; linear in the products of some with the
    first, which is so large."""
    f, p = by.shape[1:]
    q = spread.shape[1]
    twist, mean, noise = np.zeros((q, f, q)), np.zeros(f), np.zeros((f, f))
    for i in range(q):
        for a in range(f):
            for k in range(p):
                change = by[1 + i, a, k] - by[0, a, k]
                if change != 0.0:
                    for j in range(q):
                        twist[i, a, j] += change * spread[k, j]
            for k in scaled[0]:
                by_product = by[0, a, k] / scaled[1]
                for j in range(q):
                    twist[i, a, j] -= by_product * (spread[0, i] * spread[k, j] + spread[k, i] * spread[0, j])
    for a in range(f):
        for i in range(q):
            mean[a] += gain / 2.0 * twist[i, a, i]
            for b in range(f):
                for j in range(q):
                    noise[a, b] += gain**2 / 2.0 * twist[i, a, j] * twist[i, b, j]
    return mean, noise
