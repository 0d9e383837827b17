"""Parts of `filtered_row.py`'s algebra: what adds to a row's slopes, and what its own noise is."""

from __future__ import annotations

import math

import numpy as np

from cartgrasp.frames import Array

from .correction import put
from .jit import Indices, row_compiled

FILTER_RATE = 2.0
"""1/s, of the filter."""
NOMINAL_DELAY_PERIODS = 0.25
"""How late a wrench is, in sample periods: one that is held to the next is not, a mere sample is half of one."""
ROW_PERIOD = 0.1
"""s from row to row."""
STANDSTILL_SIGMAS = 3.0
"""Standard deviations of nu within which a cart may stand still, or be as fast as asked."""
MODEL_ERROR_RATIO = 0.002
"""Standard deviation of what a model leaves out, as a share of the wrench."""
SIGNIFICANCE_SIGMAS = 2.0
"""Standard deviations that teach nothing: of nu, and of what noise in slopes adds to the information."""
MEMORY_ERROR_ROWS = 4.0
"""Rows over which a memory that is off stays so: what it does counts in each as if it were new, so many times."""


@row_compiled
def part_beyond(value: float, variance: float, deviations: float) -> float:
    """The part of a number that stands out of so many standard deviations."""
    return max(1.0 - deviations**2 * variance / max(value**2, 1e-300), 0.0) * value


@row_compiled
def with_rise(slopes: Array, by_acceleration: Array, rise: Array) -> Array:
    """Slopes (f, p + 1), and what B[nu'] (f,) adds to them, with their partials by it (f, f, p)."""
    found = slopes.copy()
    for a in range(len(rise)):
        for b in range(len(rise)):
            for q in range(by_acceleration.shape[2]):
                found[a, q] += by_acceleration[a, b, q] * rise[b]
    return found


@row_compiled
def noise_of_wrenches(one: Array, other: Array, wrenches: Array, f: int) -> Array:
    """The covariance (f, f) of what noise of sensors does to two sums by weights (n,), a sample that stands for several
    moments counted whole."""
    n, total, share, beside = len(wrenches), np.zeros((f, f)), 0.0, 0.0
    for i in range(n):
        share += one[i]
        beside += other[i]
        if i + 1 == n or wrenches[i + 1, 0] != wrenches[i, 0]:
            for a in range(f):
                for b in range(f):
                    total[a, b] += share * beside * wrenches[i, 1 + f + f * a + b]
            share = beside = 0.0
    return total


@row_compiled
def add_delay(weights: tuple[Array, Array], known: float, wrenches: Array, found: tuple[Array, Array]) -> Array:
    """Adds to the last of the slopes (f, p + 1) what a second by which wrenches are late takes off B of them, which is
    B of how fast they change; and to the residual (f,) what it comes to over the time (s) by which they are `known` to
    be early. Returns the covariances (2, f, f) of what their noise does to that slope: of itself, and with what it does
    to the residual."""
    (of_motion, held), (residual, slopes), n, f = weights, found, len(wrenches), len(found[0])
    last, by, of_residual, noise = slopes.shape[1] - 1, np.empty(n), np.empty(n), np.empty((2, f, f))
    for i in range(n):
        by[i] = -FILTER_RATE * (of_motion[i] + (of_motion[n] if i + 1 == n else 0.0))
        of_residual[i] = held[i] + known * by[i]
        for a in range(f):
            slopes[a, last] += by[i] * wrenches[i, 1 + a]
    for a in range(f):
        residual[a] += known * slopes[a, last]
    put(noise_of_wrenches(by, by, wrenches, f), noise[0])
    put(noise_of_wrenches(by, of_residual, wrenches, f), noise[1])
    return noise


@row_compiled
def bent_by_delay(of_motion: Array, time: Array, wrenches: Array, f: int) -> Array:
    """How the slope by the delay changes with it, (f,), per s²: what a step of the wrench does near the end of a block
    is not linear in how late it is. What noise of sensors may do to it is taken off."""
    n, found, noise = len(wrenches), np.zeros(f), np.zeros(f)
    for i in range(n - 1):
        by = -FILTER_RATE * of_motion[i] / (time[i + 1] - time[i])
        for a in range(f):
            found[a] += by * (wrenches[i + 1, 1 + a] - wrenches[i, 1 + a])
            noise[a] += 2.0 * by**2 * wrenches[i, 1 + f + f * a + a]
    for a in range(f):
        left = found[a] ** 2 - SIGNIFICANCE_SIGMAS**2 * noise[a]
        found[a] = math.copysign(math.sqrt(max(left, 0.0)), found[a])
    return found


@row_compiled
def add_root(root: Array, scale: float, noise: Array) -> None:
    """Adds the covariance of a noise with one direction (f,), times a scale, to `noise` (f, f)."""
    for a in range(len(root)):
        for b in range(len(root)):
            noise[a, b] += scale * root[a] * root[b]


@row_compiled
def add_stuck(linear: Array, stuck: Array, noise: Array) -> None:
    """Coulomb forces where the cart may stand still, for all that nu tells: they take whatever value holds it."""
    n, f, count = stuck.shape
    total = np.empty(f)
    for c in range(count):
        total[:] = 0.0
        for a in range(f):
            for i in range(n):
                total[a] += linear[i] * stuck[i, a, c]
        add_root(total, 1.0 / ROW_PERIOD, noise)


@row_compiled
def add_other_memory(linear: Array, wrench: Array, first: int, noise: Array) -> None:
    """Half of what a memory that is a standard deviation off does; the wrenches with it begin at `first`."""
    n, f = len(linear), wrench.shape[1]
    total = np.zeros(f)
    for a in range(f):
        for i in range(n):
            total[a] += linear[i] * (wrench[first + i, a] - wrench[i, a])
    add_root(total, 0.5 * MEMORY_ERROR_ROWS, noise)


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
        noise[a, a] += (MODEL_ERROR_RATIO * size) ** 2 + 1e-10


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
