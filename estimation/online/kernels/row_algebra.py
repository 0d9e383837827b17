"""The algebra of `regressor/filtered_row.py`, which says what it is about."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.kernels.workspace import copy

from .jit import Indices, row_entry
from .row_parts import (
    FILTER_RATE,
    NOMINAL_DELAY_PERIODS,
    ROW_PERIOD,
    SIGNIFICANCE_SIGMAS,
    add_delay,
    add_measured,
    add_other_memory,
    add_stuck,
    bent_by_delay,
    curvature_of,
    noise_of_wrenches,
    part_beyond,
    with_rise,
)

ROW_BLOCK_DURATION, BLOCK_END_WIDTH, SMOOTHING_LAG = ROW_PERIOD, 0.1, 0.12
"""s: how long a block is, over how long its ends are means, and how much later its row is worked out, when they are
smoothed."""


class Weights(NamedTuple):
    """Weights of n instants in the mean over blocks of some of them, which begin a little later and later. They are for
    a function that is linear between instants (n,), and for one that is held (n - 1,). `of_motion` (3, n) is for means
    over the blocks' first and last instants, and for what is new between them.

    `of_white` is the variance, 1/s, of what the mean makes of white noise. `shared` is the part of a row's noise that
    is white, and not of the motion, and that the next row has, too. It is half at most, for the row before has as
    much."""

    linear: Array
    held: Array
    of_motion: Array
    fade: float
    of_white: float
    shared: float


class Smoothed(NamedTuple):
    """n moments: time (n,), pose (n, 3), nu and nu' (n, f), the covariance of nu (n, f, f), and memory (n, k) with its
    standard deviation; with the covariances of sums of nu over the moments (2, f, f), by the first of
    `Weights.of_motion`."""

    time: Array
    pose: Array
    velocity: Array
    acceleration: Array
    covariance: Array
    of_sums: Array
    memory: Array
    memory_std: Array


class Asked(NamedTuple):
    """Where inverse dynamics are asked for: states (m, s), nu' (m, f), parameters (m, p) and times (m,). Each of the n
    instants at nu' of zero; each with the part of nu that stands out; the last with nu' of zero and of each unit; the
    middle one around the parameters and at each column of a spread from them; and each of the n with each number of
    the memory a standard deviation more, and less."""

    state: Array
    acceleration: Array
    parameters: Array
    time: Array


class Found(NamedTuple):
    """There: the reduced wrench (m, f), and its partials by the parameters (m, f, p); and reduced forces (n, f, c) that
    may hold a cart which stands still."""

    wrench: Array
    by_parameters: Array
    stuck: Array


class UnmodelledNoise(NamedTuple):
    """The density (f, f) of disturbances that a row has to bear with, and of those that there are as a rule; how many
    times the wrenches' variance is that of white samples; and the parameters in whose products with the mass, the first
    one, a row is linear."""

    disturbance: Array
    usual: Array
    wrench_variance_factor: float
    by_mass: Indices


RowInputs = tuple[Array, float, Array, Array]
"""Wrenches as `measured_wrench.py` has them, (n - 1, width), and how long after their moments they were recorded (s);
parameters (p,), and a root of their covariance (p, q)."""


class FilteredRow(NamedTuple):
    """`residual = slopes @ (change of theta | delay) + ends @ (e_k - fade e_(k-1)) + noise`, with e what is wrong
    with the mean nu at the ends, of covariance `before` and `after`. `shared` (f, f) is the part of the noise that each
    neighbour has, too.

    `curvature` (f, f) is the covariance of what a row that is linear in the parameters leaves out, as far as they are
    known: `tr(T T) / 2` of `zᵀ T z / 2`, with standard normal z; its mean, `tr(T) / 2`, is taken off the residual. Load
    times friction is not linear.

    `by_rise` (f, f, p) are the partials of the slopes by B[nu'], and `quieter` (f, f) is how much the noise is less as
    a rule (`slope_noise.py`). `of_wrenches` (f, f) is what the noise of wrenches would be of white samples, and
    `of_delay` (2, f, f) the covariance of what it does to the slope by the delay, with itself and with the
    residual. `bent_by_delay` (f,) is how that slope changes with the delay."""

    residual: Array
    slopes: Array
    ends: Array
    fade: float
    noise: Array
    before: Array
    after: Array
    shared: Array
    curvature: Array
    by_rise: Array
    quieter: Array
    of_wrenches: Array
    of_delay: Array
    bent_by_delay: Array


def over(rows: Array) -> tuple[int, int]:
    """The number of moments before the next block, and the number in the first block and those that begin up to
    BLOCK_END_WIDTH later. The first block is alone where no moment comes so soon after it. Both are 0 where the blocks
    have not been over for the SMOOTHING_LAG."""
    n, k = len(rows), 0
    first, last = rows[0, 0], rows[n - 1, 0]
    if last - first < ROW_BLOCK_DURATION + SMOOTHING_LAG - 1e-6:
        return 0, 0
    end = n
    while k < end:
        middle = (k + end) // 2
        if rows[middle, 0] < first + ROW_BLOCK_DURATION - 1e-6:
            k = middle + 1
        else:
            end = middle
    low, end = k, n
    while low < end:
        middle = (low + end) // 2
        if rows[middle, 0] < first + ROW_BLOCK_DURATION + BLOCK_END_WIDTH - 1e-6:
            low = middle + 1
        else:
            end = middle
    end = max(end, k + 1)
    if last - rows[min(end, n) - 1, 0] < SMOOTHING_LAG - 1e-6:
        return 0, 0
    return k, end


@row_entry
def weights(time: Array, width: int) -> Weights:
    """The weights of blocks that begin at each of the first `width` of n instants, and have n - width steps each."""
    n, last = len(time) - width, time[len(time) - 1]
    linear, held, of_motion = np.zeros(n + width), np.empty(n + width - 1), np.zeros((3, n + width))
    sums, fade = np.zeros(width + 1), 0.0
    for j in range(width):
        sums[j + 1] = sums[j] + math.exp(-FILTER_RATE * (time[n + j] - last))
        fade += math.exp(-FILTER_RATE * (time[n + j] - time[j])) / width
        of_motion[0, j] = of_motion[1, n + j] = 1.0 / width
    of_white = both = own = 0.0
    for i in range(n + width - 1):
        h, share = time[i + 1] - time[i], (sums[min(i + 1, width)] - sums[max(i - n + 1, 0)]) / width
        gain, left = -math.expm1(-FILTER_RATE * h), share * math.exp(FILTER_RATE * (time[i + 1] - last))
        second = 1.0 - gain / (FILTER_RATE * h)
        linear[i] += left * (gain - second)
        linear[i + 1] += left * second
        held[i] = left * gain
        of_white += held[i] ** 2 / h
        own += held[i] ** 2
        if i >= n:
            both += held[i] * held[i - n]
    for i in range(n + width):
        of_motion[2, i] = of_motion[1, i] - fade * of_motion[0, i] - linear[i]
    return Weights(linear, held, of_motion, fade, of_white, min(both / own, 0.5))


@row_entry
def begun(weighing: Weights, block: Smoothed, theta: Array, spread: Array) -> tuple[Array, Asked]:
    """What a row around parameters (p,), known to within `spread @ z`, (p, q), needs to know."""
    n, f = block.velocity.shape
    of_rise, whole = weighing.of_motion[2], np.zeros(f)
    for a in range(f):
        for i in range(n):
            whole[a] += FILTER_RATE * of_rise[i] * block.velocity[i, a]
    k, q, middle = block.memory.shape[1], spread.shape[1], n // 2
    others = 2 * n + f + 2 + q
    m = others + 2 * k * n
    state, acceleration = np.empty((m, 3 + f + k)), np.zeros((m, f))
    parameters, time = np.empty((m, len(theta))), np.empty(m)
    for i in range(m):
        at = i % n if i < 2 * n else n - 1 if i < 2 * n + f + 1 else middle if i < others else (i - others) % n
        copy(block.pose[at], state[i, :3])
        copy(block.velocity[at], state[i, 3 : 3 + f])
        copy(block.memory[at], state[i, 3 + f :])
        copy(theta, parameters[i])
        time[i] = block.time[at]
        if n <= i < 2 * n:
            for a in range(f):
                state[i, 3 + a] = part_beyond(block.velocity[at, a], block.covariance[at, a, a], SIGNIFICANCE_SIGMAS)
    for a in range(f):
        acceleration[2 * n + 1 + a, a] = 1.0
    for j in range(q + 1):
        copy(block.acceleration[middle], acceleration[2 * n + f + 1 + j])
        for q in range(len(theta) if j > 0 else 0):
            parameters[2 * n + f + 1 + j, q] += spread[q, j - 1]
    for j in range(2 * k):
        for i in range(n):
            off = block.memory_std[i, j // 2]
            state[others + j * n + i, 3 + f + j // 2] += off if j % 2 == 0 else -off
    return whole, Asked(state, acceleration, parameters, time)


@row_entry
def row(
    weighing: Weights, rise: Array, found: Found, block: Smoothed, given: RowInputs, unmodelled: UnmodelledNoise
) -> FilteredRow:
    """The filtered row, from what was found where `begun` asked for it."""
    n, f = block.velocity.shape
    by, p, still = found.by_parameters, found.by_parameters.shape[2], 2 * n
    wrenches, ahead, theta, spread = given
    mass, slopes, by_acceleration = np.empty((f, f)), np.zeros((f, p + 1)), np.empty((f, f, p))
    residual, k, others = np.zeros(f), block.memory.shape[1], len(found.wrench) - 2 * n * block.memory.shape[1]
    for a in range(f):
        for b in range(f):
            mass[a, b] = found.wrench[still + 1 + b, a] - found.wrench[still, a]
            for q in range(p):
                by_acceleration[a, b, q] = by[still + 1 + b, a, q] - by[still, a, q]
        for i in range(n):
            residual[a] -= weighing.linear[i] * found.wrench[i, a]
        for b in range(f):
            residual[a] -= mass[a, b] * rise[b]
        for q in range(p):
            for i in range(n):
                slopes[a, q] += weighing.linear[i] * by[n + i, a, q]
    of_wrenches = noise_of_wrenches(weighing.held, weighing.held, wrenches, f)
    white = unmodelled.wrench_variance_factor * of_wrenches + weighing.of_white * unmodelled.disturbance
    noise = white.copy()
    add_stuck(weighing.linear, found.stuck, noise)
    for j in range(2 * k):
        add_other_memory(weighing.linear, found.wrench, others + j * n, noise)
    add_measured(weighing.held, wrenches, theta, (residual, slopes, noise))
    left_on_average, curvature = curvature_of(
        by[still + f + 1 : others], spread, (unmodelled.by_mass, theta[0]), weighing.linear.sum()
    )
    residual -= left_on_average
    slopes = with_rise(slopes, by_acceleration, rise)
    known = ahead - NOMINAL_DELAY_PERIODS * (block.time[n - 1] - block.time[0]) / (n - 1)
    of_delay = add_delay((weighing.of_motion[2], weighing.held), known, wrenches, (residual, slopes))
    quieter = weighing.of_white * (unmodelled.usual - unmodelled.disturbance)
    before, after, shared = block.of_sums[0], block.of_sums[1], weighing.shared * white
    bent = bent_by_delay(weighing.of_motion[2], block.time, wrenches, f)
    link = -FILTER_RATE * mass, weighing.fade, noise, before, after, shared
    return FilteredRow(residual, slopes, *link, curvature, by_acceleration, quieter, of_wrenches, of_delay, bent)
