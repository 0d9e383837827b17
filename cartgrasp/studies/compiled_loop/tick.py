"""Control periods one after the other, as `simulation.closed_loop` has them with `LearningFilter`, `SteeringTracker`,
`WrenchPlanner` and `ModelPlant`: the same kernels, with what is Python there written out;
tests/studies/test_compiled_loop.py holds the two against each other. It stops where Python has to go on: for a row of
the regression, and for a wrench that has no proven plan.
"""

from __future__ import annotations

import math

import numpy as np

from estimation.kernels import driven_motion, tracked_motion
from estimation.kernels.correction import normalised_square
from estimation.kernels.driven_block import Driven, parts
from estimation.regressor.recorded_wrenches import HELD
from planning import steering
from planning.kernels.allocation import allocate
from planning.kernels.workspace import views

from ...frames import Array
from ...kernels import entries
from ...kernels.jit import Ints
from ...kernels.workspace import MEMORY, N_PHI
from .jit import compiled, entry
from .values import Blocks, Course, Held, Series

DONE, ROW, UNPLANNED, FAILED = range(4)
"""All steps are taken; a row of the regression may be due; the wrench wanted has no proven plan; the plant's state is
not finite."""
TRACK, GIVE = range(2)
"""Where a step goes on: with the wrench wanted, or with one that is planned."""
STEP, STAGE, MOMENTS, PLACE = range(4)
"""Of `at`: the step, its stage, how many moments are tracked, and the place in the planner's workspace (-1: none)."""
JUMP, MOST_JOLT = 14.0, 100.0
MOST_FORCE = 1e6
STILL = 1e-3

Limits = tuple[float, float, float, tuple[float, float, float]]
"""The period; the plant's longest step, and `stable` of step times stiffness; BLOCK, WIDTH and LAG of rows."""

error_b, steered = compiled(steering.error_b), compiled(steering.steered)
unpack_driven, unpack_planner = compiled(parts), compiled(views)


@entry
def go_on(course: Course, blocks: Blocks, held: Held, series: Series, at: Ints, limits: Limits) -> int:
    """From where `at` (4,) is."""
    while at[STEP] < len(course.time):
        if at[STAGE] == TRACK:
            _want(course, blocks, held, at[STEP])
            if not _plan(course, blocks, held, at):
                return UNPLANNED
        at[STAGE] = TRACK
        series.state[at[STEP]], series.wrenches[at[STEP]] = held.state, held.wrenches
        _feel(course, blocks, held, series.felt[at[STEP]], at)
        _push(course, blocks, held, at[STEP], limits)
        if not np.isfinite(held.state).all():
            return FAILED
        at[STEP] += 1
        if at[STEP] < len(course.time):
            _see(course, blocks, held, series, at)
            if _is_over(blocks.moments[: at[MOMENTS]], limits[3]):
                return ROW
    return DONE


@compiled
def _is_over(time: Array, rows: tuple[float, float, float]) -> bool:
    """Whether there is a row, as `ParameterLearner.over` says."""
    block, width, lag = rows
    last, end = time[len(time) - 1], 0
    while end < len(time) and time[end] < time[0] + block + width - 1e-6:
        end += 1
    return bool(last - time[0] >= block + lag - 1e-6 and last - time[end - 1] >= lag - 1e-6)


@compiled
def _driven(blocks: Blocks) -> Driven:
    return unpack_driven(blocks.driven, blocks.plan)


@compiled
def _want(course: Course, blocks: Blocks, held: Held, k: int) -> None:
    """The tracker's wrench, for the motion and the cart that are believed."""
    d, law, asked, states, told = _driven(blocks), course.law, held.asked, held.states, held.told
    error = error_b(course.pose[k], d.mean[:3], law[0])
    nu, wanted, rate = d.mean[3:], course.velocity[k], course.acceleration[k]
    reference = ((wanted[0], wanted[1]), (rate[0], rate[1]))
    u, r = steered(error, law[1], (nu[0], nu[1]), reference, (law[2], law[3], law[4], law[5]))
    n, p, f = len(d.mean), len(held.theta), len(nu)
    for row in range(2):
        states[row, :n], states[row, n], states[row, n + 1 :] = d.mean, course.time[k], held.theta
    asked[0, : n + 1 + p], asked[0, n + 1 + p], asked[0, n + 2 + p] = states[0], u, r
    entries.inverses(blocks.cart, blocks.cart_ints, asked, told[:1])
    u, r = told[0, 0], told[0, 1]
    for a in range(f):
        if abs(wanted[a]) > STILL:
            states[1, 3 + a] = wanted[a]
    entries.effects(blocks.cart, blocks.cart_ints, states, told)
    first, width = N_PHI + N_PHI * p, MEMORY + p
    for i in range(3):
        drag = told[0, first + i * width] - told[1, first + i * width]
        u += drag * course.basis[i, 0]
        r += drag * course.basis[i, 1]
    for j in range(3):
        held.wanted[j] = u * course.along[0, j] + r * course.along[1, j]


@compiled
def _plan(course: Course, blocks: Blocks, held: Held, at: Ints) -> bool:
    w, place, wanted = unpack_planner(blocks.planner, blocks.planner_ints), course.place[at[STEP]], held.wanted
    moved = place != at[PLACE]
    if moved:
        w.points[:] = course.points[place]
    if allocate(blocks.planner, blocks.planner_ints, (wanted[0], wanted[1], wanted[2]), moved) != 0:
        at[PLACE] = -1
        return False
    at[PLACE] = place
    held.wrenches[:] = w.claim.x
    return True


@compiled
def _feel(course: Course, blocks: Blocks, held: Held, felt: Array, at: Ints) -> None:
    """The wrench as recorded: for the next row, and to drive the motion."""
    i, place, time, recorded = at[MOMENTS] - 1, course.place[at[STEP]], course.time[at[STEP]], blocks.recorded
    f = course.reduced.shape[1]
    noise, value, size = course.noise[place], np.zeros(f), 0.0
    for j in range(len(felt)):
        felt[j] += held.wrenches[j]
        for a in range(f):
            value[a] += course.reduced[place, a, j] * felt[j]
    for a in range(f):
        size += abs(value[a])
    if not size < MOST_FORCE:
        return
    if i > 0 and not math.isnan(recorded[i - 1, 0]):
        step, spread = np.empty(f), np.empty((f, f))
        for a in range(f):
            step[a] = value[a] - recorded[i - 1, 1 + a]
            for b in range(f):
                spread[a, b] = noise[a, b] + recorded[i - 1, 1 + f + f * a + b]
        if not normalised_square(step, spread, np.empty(f * f + f)) < JUMP:
            _jolt(blocks, held, step)
    recorded[i, 0], recorded[i, 1 : 1 + f] = time, value
    for a in range(f):
        for b in range(f):
            recorded[i, 1 + f + f * a + b] = noise[a, b]
    d = _driven(blocks)
    d.pushed[1], d.pushed[0] = d.pushed[0], time
    d.push[:], d.push_covariance[:] = value, noise


@compiled
def _jolt(blocks: Blocks, held: Held, step: Array) -> None:
    """The change of nu' that a step of the wrench makes."""
    f, p, asked, told = len(step), len(held.theta), held.asked, held.told
    n = asked.shape[1] - 1 - p - f
    asked[0] = 0.0
    asked[0, n + 1 : n + 1 + p] = held.theta
    entries.inverses(blocks.cart, blocks.cart_ints, asked, told[:1])
    mass = told[0, f + f * n : f + f * n + f * f].reshape((f, f))
    change = np.linalg.solve(mass, step)
    for a in range(f):
        held.jolt[a] = min(max(change[a], -MOST_JOLT), MOST_JOLT)


@compiled
def _push(course: Course, blocks: Blocks, held: Held, k: int, limits: Limits) -> None:
    """The plant's period, in steps that are short and stable enough."""
    period, longest, stable, _ = limits
    given, found, n = held.given, held.found, len(held.state)
    at = given.shape[1] - 5 - course.basis.shape[1]
    given[0, :n], given[0, n] = held.state, course.time[k]
    for i in range(3):
        given[0, at + i] = 0.0
        for j in range(len(held.wrenches)):
            given[0, at + i] += course.grasp[course.place[k], i, j] * held.wrenches[j]
    given[0, at + 3 :] = 1.0
    given[0, -2], given[0, -1] = period, 0.0
    entries.rates(blocks.plant, blocks.plant_ints, given, found)
    count = max(1, math.ceil(period / longest - 1e-9))
    jacobian = found[0, n : n + n * n].reshape((n, n))
    if np.isfinite(jacobian).all() and period * _bound(jacobian) / stable > count:
        stiffness = np.abs(np.linalg.eigvals(jacobian.astype(np.complex128))).max()
        count = max(count, math.ceil(period * stiffness / stable))
    given[0, -2], given[0, -1] = period / count, count
    entries.rates(blocks.plant, blocks.plant_ints, given, held.nothing)
    held.state[:] = given[0, :n]


@compiled
def _bound(matrix: Array) -> float:
    """Of the largest eigenvalue: the smaller one of two norms."""
    n, by_rows, by_columns = len(matrix), 0.0, 0.0
    for i in range(n):
        row = column = 0.0
        for j in range(n):
            row, column = row + abs(matrix[i, j]), column + abs(matrix[j, i])
        by_rows, by_columns = max(by_rows, row), max(by_columns, column)
    return min(by_rows, by_columns)


@compiled
def _see(course: Course, blocks: Blocks, held: Held, series: Series, at: Ints) -> None:
    """Pose and velocity as sensed, into the motion that is tracked and the one that is driven."""
    k, i, state, seen, f = at[STEP], at[MOMENTS], held.state, held.seen, course.basis.shape[1]
    pose, velocity, time, before = series.pose[k], series.velocity[k], course.time[k], course.time[k - 1]
    x = y = turn = 0.0
    for a in range(f):
        x, y = x + course.basis[0, a] * state[3 + a], y + course.basis[1, a] * state[3 + a]
        turn += course.basis[2, a] * state[3 + a]
    cosine, sine = math.cos(state[2]), math.sin(state[2])
    for j in range(3):
        pose[j] += state[j]
    velocity[0] += cosine * x - sine * y
    velocity[1] += sine * x + cosine * y
    velocity[2] += turn
    seen[:3], seen[3:] = pose, velocity
    tracked_motion.follow(blocks.rows, i, time - before, blocks.known, seen, held.jolt)
    blocks.moments[i] = time
    held.jolt[:] = 0.0
    recorded = blocks.recorded
    recorded[i] = recorded[i - 1]
    if not time - recorded[i, 0] < HELD:
        recorded[i, 0] = math.nan
    at[MOMENTS] = i + 1
    driven_motion.drive(blocks.cart, blocks.cart_ints, blocks.driven, blocks.plan, seen, (before, time))
