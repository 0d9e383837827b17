"""A cart's dynamics at one state, with all partials.

State (n,) is `(pose | nu | memory)`, parameters (p,) are `(phi | effects' values)`, as `CartModel` orders them.
Inverse dynamics are what is written down (physics.md); forward dynamics follow by solving for nu':

    Sᵀ wrench_b = Sᵀ (Y(v, S nu') phi - effects).

Of phi's mass a part may swing along {b}'s x (`SWINGING_ROW`): it does not follow u', so that ms u' joins the effects,
and M_b loses ms.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cartgrasp.frames import Array

from . import rigid_body
from .jit import Ints, compiled
from .situation import SWINGING_ROW, EffectValues, KernelSituation, Parts, Twist
from .vocabulary import add_memory_rate, add_phi_change, add_stiction, add_wrench, settle
from .wheel_loads import carry
from .workspace import MEMORY_COLUMN, PHI_COLUMN, POSE_COLUMN, VELOCITY_COLUMN, Workspace, copy


class Point(NamedTuple):
    """Where dynamics are asked for: state (n,), time (s), parameters (p,); and what effects without a kernel add, as
    `Workspace.sums` has it, or nothing (0,)."""

    state: Array
    time: float
    parameters: Array
    foreign: Array


class Inverse(NamedTuple):
    """The reduced wrench (f,), its partials by nu' (f, f), parameters (f, p) and state (f, n), and the memory's rate
    (k,) with partials by state (k, n) and parameters (k, p)."""

    wrench: Array
    by_acceleration: Array
    by_parameters: Array
    by_state: Array
    memory_rate: Array
    memory_rate_by_state: Array
    memory_rate_by_parameters: Array


@compiled
def reduced(m: Workspace, point: Point, acceleration: Array, wrench: Array, mass: Array) -> None:
    """The reduced wrench (f,) at nu' = `acceleration` (f,) and the mass matrix (f, f); fills the sums."""
    twist, turn = lifted(m.basis, point.state[3:]), lifted(m.basis, acceleration)
    sum_effects(m, point, situation(m, point, twist))
    if turn[0] != 0.0:
        for q in range(m.wrench.shape[1]):
            m.wrench[0, q] += turn[0] * m.wrench[SWINGING_ROW, q]
    rigid, whole = rigid_body.regressor(twist, turn), mass_matrix(m)
    basis, n_free = m.basis, m.basis.shape[1]
    wrench[:], mass[:] = 0.0, 0.0
    for a in range(n_free):
        for i in range(3):
            along = basis[i, a]
            if along == 0.0:
                continue
            wrench[a] -= along * m.wrench[i, 0]
            for c in range(4):
                wrench[a] += along * rigid[i][c] * m.phi[c]
            for j in range(3):
                for b in range(n_free):
                    mass[a, b] += along * whole[i][j] * basis[j, b]


@compiled
def inverse_by_parameters(m: Workspace, point: Point, acceleration: Array, out: tuple[Array, Array, Array]) -> None:
    """Fills `out` as `reduced` does, and with the wrench's partials by the parameters (f, p), if there is room for
    them."""
    wrench, mass, by_parameters = out
    rigid = rigid_body.regressor(lifted(m.basis, point.state[3:]), lifted(m.basis, acceleration))
    reduced(m, point, acceleration, wrench, mass)  # which may stand where nu' does
    if len(by_parameters) == 0:
        return
    basis, first = m.basis, MEMORY_COLUMN + len(m.memory_rate)
    by_parameters[:] = 0.0
    for a in range(basis.shape[1]):
        for i in range(3):
            along = basis[i, a]
            if along == 0.0:
                continue
            for q in range(len(point.parameters)):
                by_parameters[a, q] -= along * m.wrench[i, first + q]
            for c in range(4):
                by_phi = along * (rigid[i][c] - m.wrench[i, PHI_COLUMN + c])
                _add_by_phi(m.phi_by_parameters[c], by_phi, by_parameters[a])


@compiled
def inverse(m: Workspace, point: Point, acceleration: Array, out: Inverse) -> None:
    """Inverse dynamics at nu' = `acceleration` (f,), into the arrays of `out`."""
    inverse_by_parameters(m, point, acceleration, (out.wrench, out.by_acceleration, out.by_parameters))
    bias = rigid_body.by_velocity(lifted(m.basis, point.state[3:]), m.phi)
    basis, wrench, n_free, n_memory = m.basis, m.wrench, m.basis.shape[1], len(m.memory_rate)
    out.by_state[:] = 0.0
    for a in range(n_free):
        for i in range(3):
            along = basis[i, a]
            if along == 0.0:
                continue
            for j in range(3):
                out.by_state[a, j] -= along * wrench[i, POSE_COLUMN + j]
                for b in range(n_free):
                    out.by_state[a, 3 + b] += along * (bias[i][j] - wrench[i, VELOCITY_COLUMN + j]) * basis[j, b]
            for k in range(n_memory):
                out.by_state[a, 3 + n_free + k] -= along * wrench[i, MEMORY_COLUMN + k]
    out.memory_rate_by_state[:] = 0.0
    for k in range(n_memory):
        rate = m.memory_rate[k]
        out.memory_rate[k] = rate[0]
        for j in range(3):
            out.memory_rate_by_state[k, j] = rate[POSE_COLUMN + j]
            for b in range(n_free):
                out.memory_rate_by_state[k, 3 + b] += rate[VELOCITY_COLUMN + j] * basis[j, b]
        copy(rate[MEMORY_COLUMN:], out.memory_rate_by_state[k, 3 + n_free :])
        copy(rate[MEMORY_COLUMN + n_memory :], out.memory_rate_by_parameters[k])


@compiled
def rate_alone(m: Workspace, point: Point, push: Array, room: Array) -> None:
    """Writes the rate of the state (n,) into `room`, as `forward` does, without any partials."""
    n, n_free = len(point.state), m.basis.shape[1]
    rest, mass = room[3 : 3 + n_free], room[n : n + n_free * n_free].reshape((n_free, n_free))
    rest[:] = 0.0
    reduced(m, point, rest, rest, mass)
    hold(m, mass)
    for a in range(n_free):
        for i in range(3):
            rest[a] -= m.basis[i, a] * push[i]
    solve(mass, rest.reshape((n_free, 1)))
    for k in range(len(m.memory_rate)):
        room[3 + n_free + k] = m.memory_rate[k, 0]
    cosine, sine = math.cos(point.state[2]), math.sin(point.state[2])
    u, w, r = lifted(m.basis, point.state[3:])
    room[0], room[1], room[2] = cosine * u - sine * w, sine * u + cosine * w, r


@compiled
def forward(m: Workspace, point: Point, push: Array, room: Array) -> None:
    """Rate of the state (n,), its partials by state (n, n), wrench (n, 3) and parameters (n, p), one after the other
    into `room`, with f² numbers to spare. `push` (3,): a wrench in {b}."""
    n, p, n_free = len(point.state), len(point.parameters), m.basis.shape[1]
    first, last = n + n * n, n + n * n + 3 * n
    value, by_state, by_wrench = room[:n], room[n:first].reshape((n, n)), room[first:last].reshape((n, 3))
    by_parameters, end = room[last : last + n * p].reshape((n, p)), last + n * p
    mass = room[end : end + n_free * n_free].reshape((n_free, n_free))
    free, rest = 3 + n_free, value[3 : 3 + n_free]
    rest[:] = 0.0
    out = Inverse(
        rest,
        mass,
        by_parameters[3:free],
        by_state[3:free],
        value[free:],
        by_state[free:],
        by_parameters[free:],
    )
    inverse(m, point, rest, out)
    hold(m, mass)
    by_wrench[:] = 0.0
    for a in range(n_free):
        for i in range(3):
            rest[a] -= m.basis[i, a] * push[i]
            by_wrench[3 + a, i] = -m.basis[i, a]
    solve(mass, rest.reshape((n_free, 1)))
    solve(mass, by_wrench[3:free])
    x = y = turn = 0.0
    for a in range(n_free):
        x, y, turn = x + m.basis[0, a] * rest[a], y + m.basis[1, a] * rest[a], turn + m.basis[2, a] * rest[a]
    still = rigid_body.regressor((0.0, 0.0, 0.0), (x, y, turn))
    for a in range(n_free):
        for i in range(3):
            for c in range(4):
                _add_by_phi(m.phi_by_parameters[c], m.basis[i, a] * still[i][c], out.by_parameters[a])
        for q in range(p if m.wrench[SWINGING_ROW, 0] != 0.0 else 0):
            out.by_parameters[a, q] -= (
                m.basis[0, a] * x * m.wrench[SWINGING_ROW, MEMORY_COLUMN + len(m.memory_rate) + q]
            )
    solve(mass, out.by_state)
    solve(mass, out.by_parameters)
    by_parameters[:3] = 0.0
    by_state[:3] = 0.0
    _move(m.basis, point.state, value, by_state)


@compiled
def situation(m: Workspace, point: Point, twist: Twist) -> KernelSituation:
    """What effects look at. Sums begin with what is foreign."""
    if len(point.foreign) > 0:
        copy(point.foreign, m.sums)
    else:
        m.sums[:] = 0.0
    for c in range(4):
        m.phi[c] += point.parameters[c]
        m.phi_by_parameters[c, c] += 1.0
    for e in range(len(m.effects)):
        kind, first, last = m.effects[e, 0], m.effects[e, 1], m.effects[e, 2]
        own = EffectValues(point.state[:0], point.parameters[first:last], m.constants[:0])
        add_phi_change(kind, point.time, own, (m.phi, m.phi_by_parameters[:, first:last]))
    carry(m.wheels, m.phi, m.gravity, (m.loads, m.carried, m.standing))
    return _carried(m, point, twist)


@compiled
def _carried(m: Workspace, point: Point, twist: Twist) -> KernelSituation:
    """The situation with phi and loads as they stand in the workspace."""
    pose = point.state[:3]
    return KernelSituation(point.time, pose, twist, m.phi, m.wheels, m.loads, m.carried, m.pivots, m.smoothing_speed)


@compiled
def mass_matrix(m: Workspace) -> tuple[Twist, Twist, Twist]:
    """M_b (3, 3), without what swings."""
    x, y, turn = rigid_body.mass_matrix(m.phi)
    return (x[0] - m.wrench[SWINGING_ROW, 0], x[1], x[2]), y, turn


@compiled
def sum_effects(m: Workspace, point: Point, at: KernelSituation) -> None:
    """Fills the sums of wrenches and of the memory's rate."""
    for e in range(len(m.effects)):
        kind, begin, end = m.effects[e, 0], m.effects[e, 3], m.effects[e, 4]
        own = own_of(m, e, point)
        add_wrench(kind, at, own, _parts(m.wrench, m.effects[e], len(m.memory_rate)))
        if m.effects[e, 7] == 1:
            add_memory_rate(kind, at, own, _parts(m.memory_rate[begin:end], m.effects[e], len(m.memory_rate)))


@compiled
def hold(m: Workspace, mass: Array) -> None:
    """Where accelerations are solved for: lets no more swing, whatever the parameters, than leaves M_b positive, and
    mends `mass` (f, f), if there is any. Inverse dynamics stay linear in what swings, which fits need."""
    swung, n_parameters = m.wrench[SWINGING_ROW], m.phi_by_parameters.shape[1]
    if swung[0] <= 0.0:
        return
    most, by_phi = rigid_body.most_swinging(m.phi)
    if swung[0] > most:
        for a in range(len(mass)):
            for b in range(len(mass)):
                mass[a, b] += m.basis[0, a] * m.basis[0, b] * (swung[0] - most)
        swung[:] = 0.0
        swung[0] = most
        for c in range(4):
            _add_by_phi(m.phi_by_parameters[c], by_phi[c], swung[len(swung) - n_parameters :])


@compiled
def sum_memory_rates(m: Workspace, point: Point, at: KernelSituation) -> None:
    """Sums the memories' rates alone, without the other sums that `sum_effects` fills."""
    for e in range(len(m.effects)):
        kind, begin, end = m.effects[e, 0], m.effects[e, 3], m.effects[e, 4]
        if m.effects[e, 7] == 1:
            own = own_of(m, e, point)
            add_memory_rate(kind, at, own, _parts(m.memory_rate[begin:end], m.effects[e], len(m.memory_rate)))


@compiled
def stictions(m: Workspace, point: Point, columns: Array) -> int:
    """Wrenches (3,) that Coulomb effects may give near standstill, one after the other, each times the root of how long
    it keeps its value; returns how many. The last `situation` was asked for at this point."""
    at, count = _carried(m, point, lifted(m.basis, point.state[3:])), 0
    columns[:] = 0.0
    stuck = columns.reshape((len(columns) // 3, 3))
    for e in range(len(m.effects)):
        own = own_of(m, e, point)
        more = add_stiction(m.effects[e, 0], at, own, stuck[count:])
        for c in range(count, count + more):
            for i in range(3):
                stuck[c, i] *= m.roots[e]
        count += more
    return count


@compiled
def settle_all(m: Workspace, point: Point, at: KernelSituation, memory: Array) -> None:
    """The memory (k,) when it has come to rest."""
    copy(point.state[3 + m.basis.shape[1] :], memory)
    for e in range(len(m.effects)):
        own = own_of(m, e, point)
        settle(m.effects[e, 0], at, own, memory[m.effects[e, 3] : m.effects[e, 4]])


@compiled
def own_of(m: Workspace, e: int, point: Point) -> EffectValues:
    effect, first = m.effects[e], 3 + m.basis.shape[1]
    memory = point.state[first + effect[3] : first + effect[4]]
    return EffectValues(memory, point.parameters[effect[1] : effect[2]], m.constants[effect[5] : effect[6]])


@compiled
def _parts(rows: Array, effect: Ints, n_memory: int) -> Parts:
    """Where an effect adds to rows of sums."""
    first = MEMORY_COLUMN + n_memory
    return Parts(
        rows[:, 0],
        rows[:, POSE_COLUMN:VELOCITY_COLUMN],
        rows[:, VELOCITY_COLUMN:PHI_COLUMN],
        rows[:, PHI_COLUMN:MEMORY_COLUMN],
        rows[:, MEMORY_COLUMN + effect[3] : MEMORY_COLUMN + effect[4]],
        rows[:, first + effect[1] : first + effect[2]],
    )


@compiled
def lifted(basis: Array, free: Array) -> Twist:
    """S nu."""
    x = y = turn = 0.0
    for a in range(basis.shape[1]):
        x, y, turn = x + basis[0, a] * free[a], y + basis[1, a] * free[a], turn + basis[2, a] * free[a]
    return x, y, turn


@compiled
def _add_by_phi(phi_by_parameters: Array, slope: float, by_parameters: Array) -> None:
    """Adds a partial by one of phi, which parameters make."""
    if slope != 0.0:
        for q in range(len(by_parameters)):
            by_parameters[q] += slope * phi_by_parameters[q]


@compiled
def solve(matrix: Array, side: Array) -> None:
    """Puts `-matrix⁻¹ side` in the place of `side` (f, k); the matrix is symmetric."""
    if len(matrix) == 1:
        for k in range(side.shape[1]):
            side[0, k] = -side[0, k] / matrix[0, 0]
    elif len(matrix) == 2:
        a, b, c = matrix[0, 0], matrix[0, 1], matrix[1, 1]
        scale = -1.0 / (a * c - b * b)
        for k in range(side.shape[1]):
            x, y = side[0, k], side[1, k]
            side[0, k], side[1, k] = scale * (c * x - b * y), scale * (a * y - b * x)
    else:
        a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
        d, e, f = matrix[1, 1], matrix[1, 2], matrix[2, 2]
        df, cf, cd = d * f - e * e, c * e - b * f, b * e - c * d
        scale = -1.0 / (a * df + b * cf + c * cd)
        for k in range(side.shape[1]):
            x, y, z = side[0, k], side[1, k], side[2, k]
            side[0, k] = scale * (df * x + cf * y + cd * z)
            side[1, k] = scale * (cf * x + (a * f - c * c) * y + (b * c - a * e) * z)
            side[2, k] = scale * (cd * x + (b * c - a * e) * y + (a * d - b * b) * z)


@compiled
def _move(basis: Array, state: Array, value: Array, by_state: Array) -> None:
    """The rate of the pose, R(theta) S nu, with its partials."""
    cosine, sine = math.cos(state[2]), math.sin(state[2])
    u, w, r = lifted(basis, state[3:])
    value[0], value[1], value[2] = cosine * u - sine * w, sine * u + cosine * w, r
    by_state[0, 2], by_state[1, 2] = -value[1], value[0]
    for b in range(basis.shape[1]):
        by_state[0, 3 + b] = cosine * basis[0, b] - sine * basis[1, b]
        by_state[1, 3 + b] = sine * basis[0, b] + cosine * basis[1, b]
        by_state[2, 3 + b] = basis[2, b]
