"""What Python and kernels of other packages call. Each entry takes a workspace, a stack of rows to be `given` and a
stack of rows to be `found`, of which it fills every number. A given row begins with the state (n,), the time and the
parameters (p,), and may end with what effects without a kernel add."""

from __future__ import annotations

import math

from cartgrasp.frames import Array

from .dynamics import (
    Inverse,
    Point,
    forward,
    hold,
    inverse,
    inverse_by_parameters,
    lifted,
    rate_alone,
    settle_all,
    situation,
    stictions,
    sum_effects,
    sum_memory_rates,
)
from .floor import react
from .jit import Ints, compiled, entry
from .workspace import copy, unpack

MEMORY_STEP = 0.01
"""s."""


@entry
def rates(floats: Array, ints: Ints, given: Array, found: Array) -> None:
    """Given `push` (3,), a step and a number of steps too. Takes so many classical fourth-order steps, which move
    the given state and time; then finds what `forward` does, or the first numbers of it."""
    m, room = unpack(floats, ints)
    n, p = _sizes(ints)
    moved, total = room[len(room) - n :], room[len(room) - 2 * n : len(room) - n]
    for i in range(len(given)):
        point, rest = _point(given[i], n, p, 5)
        state, begin, step = point.state, point.time, rest[3]
        n_stages = 4 * round(rest[4])
        for k in range(n_stages + 1):
            stage, inside = k % 4, 0.0 if k % 4 == 0 else step if k % 4 == 3 else step / 2.0
            for j in range(n):
                moved[j] = state[j] + inside * room[j] if stage > 0 else state[j]
            time = begin + k // 4 * step + inside
            here = Point(moved, time, point.parameters, point.foreign)
            if k == n_stages:
                if found.shape[1] > 0:
                    forward(m, here, rest[:3], room)
                break
            rate_alone(m, here, rest[:3], room)
            for j in range(n):
                weight = step / 6.0 if stage % 3 == 0 else step / 3.0
                total[j] = (total[j] if stage > 0 else state[j]) + weight * room[j]
            if stage == 3:
                copy(total, state)
        given[i, n] = begin + n_stages // 4 * step
        copy(room, found[i])


@entry
def inverses(floats: Array, ints: Ints, given: Array, found: Array) -> None:
    """Given nu' (f,) too: `Inverse`, its parts one after the other, or the first three of them."""
    m, _ = unpack(floats, ints)
    n, p = _sizes(ints)
    f, k = m.basis.shape[1], len(m.memory_rate)
    for i in range(len(given)):
        point, acceleration = _point(given[i], n, p, f)
        out, at = found[i], f
        by_acceleration, at = out[at : at + f * f].reshape((f, f)), at + f * f
        by_parameters, at = out[at : at + f * p].reshape((f, p)), at + f * p
        if at == len(out):
            inverse_by_parameters(m, point, acceleration, (out[:f], by_acceleration, by_parameters))
            continue
        by_state, at = out[at : at + f * n].reshape((f, n)), at + f * n
        rate, at = out[at : at + k], at + k
        rate_by_state, at = out[at : at + k * n].reshape((k, n)), at + k * n
        rate_by_parameters = out[at : at + k * p].reshape((k, p))
        parts = Inverse(out[:f], by_acceleration, by_parameters, by_state, rate, rate_by_state, rate_by_parameters)
        inverse(m, point, acceleration, parts)


@entry
def memories(floats: Array, ints: Ints, given: Array, found: Array) -> None:
    """The memory (k,) along a motion: rows are instants one after the other, of which only the first one's memory
    counts. Between them pose and velocity go straight; classical fourth-order steps of at most `MEMORY_STEP`."""
    m, room = unpack(floats, ints)
    n, p = _sizes(ints)
    k, first = len(m.memory_rate), 3 + m.basis.shape[1]
    moved, total, memory = room[:n], room[n : n + k], room[2 * n : 2 * n + k]
    copy(given[0, first:n], memory)
    for i in range(len(given)):
        copy(memory, found[i])
        if i + 1 == len(given):
            break
        point, _ = _point(given[i], n, p, 0)
        after, _ = _point(given[i + 1], n, p, 0)
        duration = after.time - point.time
        count = max(1, math.ceil(duration / MEMORY_STEP - 1e-9))
        step = duration / count
        for stage in range(4 * count):
            inside = (stage // 4 + (0.0 if stage % 4 == 0 else 1.0 if stage % 4 == 3 else 0.5)) / count
            for j in range(first):
                moved[j] = point.state[j] + inside * (after.state[j] - point.state[j])
            ahead = 0.0 if stage % 4 == 0 else step if stage % 4 == 3 else step / 2.0
            for j in range(k):
                moved[first + j] = memory[j] + (ahead * m.memory_rate[j, 0] if stage % 4 > 0 else 0.0)
            here = Point(moved, point.time + inside * duration, point.parameters, point.foreign)
            sum_memory_rates(m, here, situation(m, here, lifted(m.basis, moved[3:])))
            weight = step / 6.0 if stage % 4 in (0, 3) else step / 3.0
            for j in range(k):
                total[j] = (memory[j] if stage % 4 == 0 else total[j]) + weight * m.memory_rate[j, 0]
            if stage % 4 == 3:
                copy(total, memory)


@entry
def effects(floats: Array, ints: Ints, given: Array, found: Array) -> int:
    """`Workspace.sums`; the memory (k,) when it has come to rest; stiction: wrenches (3,), as many as are returned."""
    m, _ = unpack(floats, ints)
    n, p = _sizes(ints)
    last = len(m.sums) + len(m.memory_rate)
    count = 0
    for i in range(len(given)):
        point, _ = _point(given[i], n, p, 0)
        at = situation(m, point, lifted(m.basis, point.state[3:]))
        sum_effects(m, point, at)
        hold(m, m.phi_by_parameters[:0])
        copy(m.sums, found[i])
        settle_all(m, point, at, found[i, len(m.sums) : last])
        count = stictions(m, point, found[i, last:])
    return count


@entry
def floors(floats: Array, ints: Ints, given: Array, found: Array) -> None:
    """Given the CoM's height too: the rows of `floor.react`, and their partials if there is room for them."""
    m, room = unpack(floats, ints)
    n, p = _sizes(ints)
    size = 7 * (len(m.wheels) + 1)
    for i in range(len(given)):
        point, rest = _point(given[i], n, p, 1)
        rows, slopes = found[i, :size].reshape((len(m.wheels) + 1, 7)), found[i, size:]
        react(m, point, rest[0], (room, rows, slopes.reshape((len(slopes) // size, len(m.wheels) + 1, 7))))


@compiled
def _sizes(ints: Ints) -> tuple[int, int]:
    """The sizes of the state and of the parameters."""
    return 3 + ints[3] + ints[4], ints[5]


@compiled
def _point(row: Array, n: int, p: int, n_push: int) -> tuple[Point, Array]:
    end = n + 1 + p
    return Point(row[:n], row[n], row[n + 1 : end], row[end + n_push :]), row[end : end + n_push]
