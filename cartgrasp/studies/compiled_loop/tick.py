"""Control periods one after the other, as `simulation.closed_loop` has them with `LearningFilter`, `SteeringTracker`,
`WrenchPlanner` and `ModelPlant`: the same kernels, with what is Python there written out;
tests/studies/test_compiled_loop.py holds the two against each other. It stops where Python has to go on: for a row of
the regression, and for a wrench that has no proven plan.
"""

from __future__ import annotations

import math

import numpy as np

from estimation.online.kernels import recorded_moment, row_algebra, schmidt_steps, tracked_motion
from estimation.online.kernels.measured_wrench import MeasuredWrench, record_wrench
from estimation.online.kernels.schmidt_block import parts
from planning import steering
from planning.kernels.allocation import allocate
from planning.kernels.workspace import views

from ...frames import Array
from ...kernels import entries
from ...kernels.jit import Ints
from ...kernels.workspace import MEMORY_COLUMN, N_PHI, copy
from .jit import compiled, entry, making_arrays
from .values import LoopState, RunHistory, RunInputs, Workspaces

RUN_DONE, ROW_DUE, PLAN_MISSING, STATE_NOT_FINITE = range(4)
"""All steps are taken; a row of the regression may be due; the wrench wanted has no proven plan; the plant's state is
not finite."""
STAGE_TRACK, STAGE_APPLY = range(2)
"""Where a step goes on: with the wrench wanted, or with one that is planned."""
I_STEP, I_STAGE, I_MOMENTS, I_PLACE, I_UNFINISHED = range(5)
"""Entries of `at`: the step, its stage, how many moments are tracked, the place in the planner's workspace (-1: none),
and whether a row is left unfinished (1)."""

StepLimits = tuple[float, float, float]
"""The period; the plant's longest step, and `stable` of step times stiffness."""

error_b, steered = compiled(steering.error_b), compiled(steering.steered)
unpack_driven, unpack_planner, known_of = compiled(parts), compiled(views), compiled(tracked_motion.known_of)
over = compiled(row_algebra.over)


@entry
def run_steps(
    course: RunInputs, blocks: Workspaces, held: LoopState, series: RunHistory, at: Ints, limits: StepLimits
) -> int:
    """Runs the loop on from where `at` (5,) is; returns why it stops."""
    while at[I_STEP] < len(course.time):
        if at[I_STAGE] == STAGE_TRACK:
            _want(course, blocks, held, at[I_STEP])
            if not _plan(course, blocks, held, at):
                return PLAN_MISSING
        at[I_STAGE] = STAGE_TRACK
        copy(held.state, series.state[at[I_STEP]])
        copy(held.wrenches, series.wrenches[at[I_STEP]])
        _feel(course, blocks, held, series.felt[at[I_STEP]], at)
        _push(course, blocks, held, at[I_STEP], limits)
        for i in range(len(held.state)):
            if not math.isfinite(held.state[i]):
                return STATE_NOT_FINITE
        at[I_STEP] += 1
        if at[I_STEP] < len(course.time):
            _see(course, blocks, held, series, at)
            if at[I_UNFINISHED] or over(blocks.rows[: at[I_MOMENTS]])[0] > 0:
                return ROW_DUE
    return RUN_DONE


@compiled
def _want(course: RunInputs, blocks: Workspaces, held: LoopState, k: int) -> None:
    """The tracker's wrench, for the motion and the cart that are believed."""
    d, law = unpack_driven(blocks.driven, blocks.plan), course.law
    asked, states, told = held.asked, held.states, held.told
    error = error_b(course.pose[k], d.mean[:3], law[0])
    nu, wanted, rate = d.mean[3 : 3 + course.basis.shape[1]], course.velocity[k], course.acceleration[k]
    reference = ((wanted[0], wanted[1]), (rate[0], rate[1]))
    u, r = steered(error, law[1], (nu[0], nu[1]), reference, (law[2], law[3], law[4], law[5], law[6]))
    n, p, f = len(d.mean), len(held.theta), len(nu)
    for row in range(2):
        copy(d.mean[: 3 + f], states[row, : 3 + f])
        states[row, 3 + f : n] = 0.0  # nobody sees where casters point
        copy(held.theta, states[row, n + 1 :])
        states[row, n] = course.time[k]
    copy(states[0], asked[0, : n + 1 + p])
    asked[0, n + 1 + p], asked[0, n + 2 + p] = u, r
    entries.inverses(blocks.cart, blocks.cart_ints, asked, told[:1])
    u, r = told[0, 0], told[0, 1]
    for a in range(f):
        if abs(wanted[a]) > steering.MIN_REFERENCE_SPEED:
            states[1, 3 + a] = wanted[a]
    entries.effects(blocks.cart, blocks.cart_ints, states, told)
    first, width = N_PHI + N_PHI * p, MEMORY_COLUMN + n - 3 - f + p
    for i in range(3):
        drag = told[0, first + i * width] - told[1, first + i * width]
        u += drag * course.basis[i, 0]
        r += drag * course.basis[i, 1]
    for j in range(3):
        held.wanted[j] = u * course.along[0, j] + r * course.along[1, j]


@compiled
def _plan(course: RunInputs, blocks: Workspaces, held: LoopState, at: Ints) -> bool:
    w, place, wanted = unpack_planner(blocks.planner, blocks.planner_ints), course.place[at[I_STEP]], held.wanted
    moved = place != at[I_PLACE]
    for arm in range(len(w.points) if moved else 0):
        copy(course.points[place, arm], w.points[arm])
    if allocate(blocks.planner, blocks.planner_ints, (wanted[0], wanted[1], wanted[2]), moved) != 0:
        at[I_PLACE] = -1
        return False
    at[I_PLACE] = place
    copy(w.claim.x, held.wrenches)
    return True


@compiled
def _feel(course: RunInputs, blocks: Workspaces, held: LoopState, felt: Array, at: Ints) -> None:
    """The wrench as recorded: for the next row, and to drive the motion."""
    i, time, grip = at[I_MOMENTS] - 1, course.time[at[I_STEP]], course.grip[course.place[at[I_STEP]]]
    for j in range(len(felt)):
        felt[j] += held.wrenches[j]
    room = known_of(blocks.known, len(grip)).room
    if record_wrench(blocks.rows, i, time, MeasuredWrench(felt, grip, held.believed), room):
        schmidt_steps.push(unpack_driven(blocks.driven, blocks.plan), time, blocks.rows[i, 1:])


@compiled
def _push(course: RunInputs, blocks: Workspaces, held: LoopState, k: int, limits: StepLimits) -> None:
    """The plant's period, in steps that are short and stable enough."""
    period, longest, stable = limits
    given, found, n = held.given, held.found, len(held.state)
    at = given.shape[1] - 5
    copy(held.state, given[0, :n])
    given[0, n] = course.time[k]
    for i in range(3):
        given[0, at + i] = 0.0
        for j in range(len(held.wrenches)):
            given[0, at + i] += course.grasp[course.place[k], i, j] * held.wrenches[j]
    given[0, -2], given[0, -1] = period, 0.0
    entries.rates(blocks.plant, blocks.plant_ints, given, found)
    count = max(1, math.ceil(period / longest - 1e-9))
    jacobian = found[0, n : n + n * n].reshape((n, n))
    if period * _bound(jacobian) / stable > count:
        count = max(count, math.ceil(period * _stiffness(jacobian) / stable))
    given[0, -2], given[0, -1] = period / count, count
    entries.rates(blocks.plant, blocks.plant_ints, given, held.nothing)
    copy(given[0], held.state)


@compiled
def _bound(matrix: Array) -> float:
    """A bound on the magnitude of the largest eigenvalue: the smaller one of two norms; 0 where a number is not
    finite."""
    n, by_rows, by_columns, total = len(matrix), 0.0, 0.0, 0.0
    for i in range(n):
        row = column = 0.0
        for j in range(n):
            row, column = row + abs(matrix[i, j]), column + abs(matrix[j, i])
        by_rows, by_columns, total = max(by_rows, row), max(by_columns, column), total + row
    return min(by_rows, by_columns) if math.isfinite(total) else 0.0


@making_arrays
def _stiffness(matrix: Array) -> float:
    """The largest eigenvalue."""
    return float(np.abs(np.linalg.eigvals(matrix.astype(np.complex128))).max())


@compiled
def _see(course: RunInputs, blocks: Workspaces, held: LoopState, series: RunHistory, at: Ints) -> None:
    """Pose and velocity as sensed, into the motion that is tracked and the one that is driven."""
    k, i, state, seen, f = at[I_STEP], at[I_MOMENTS], held.state, held.seen, course.basis.shape[1]
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
    copy(pose, seen[:3])
    copy(velocity, seen[3:])
    recorded_moment.go_on(
        blocks.rows, blocks.known, i, time, MeasuredWrench(held.wrenches, course.grip[0], held.believed)
    )
    tracked_motion.take(blocks.rows, i, blocks.known, seen, f)
    at[I_MOMENTS] = i + 1
    schmidt_steps.drive(
        blocks.cart, blocks.cart_ints, blocks.driven, blocks.plan, before, time, seen, held.unfelt, math.nan
    )
