"""A step of the motion that recorded wrenches drive, with the parameters considered: known to within a covariance,
and not taught by it (Schmidt 1966).

All that is believed and known stands in one block of memory, as in `schmidt_block.py`. Where a cart's effects all have
kernels, `drive` asks them for the rate, so that a sample is one call; `predict` and `take` are for those whose rate
comes from elsewhere.
"""

from __future__ import annotations

import math

from cartgrasp.frames import Array
from cartgrasp.kernels.dynamics import Point, forward, lifted, settle_all, situation, stictions
from cartgrasp.kernels.workspace import copy
from cartgrasp.kernels.workspace import unpack as unpack_cart

from . import sensor_health
from .correction import INNOVATION_GATE, Believed, add_congruence, carved, eliminate, take_pose, take_velocity
from .free_directions import add_creep, raised
from .jit import Indices, compiled, entry
from .measured_wrench import WRENCH_HOLD_TIME
from .relocalisation import is_relocalised, restart_motion
from .schmidt_block import N_BLOCK_SIZES, Considered, parts

MAX_FILTER_STEP = 0.01
MAX_INSTABILITY_EFOLDINGS = 12.0
"""e-foldings of an instability after which nothing is poised there any more."""

unpack, note, said_of = compiled(parts), compiled(sensor_health.note), compiled(sensor_health.said_of)


# Many parameters: arrays of a kernel, which takes no values with fields.
@entry
def drive(
    floats: Array,
    ints: Indices,
    block: Array,
    plan: Indices,
    begin: float,
    end: float,
    seen: Array,
    felt: Array,
    gate_ratio: float,
) -> int:
    """From a time to another with nothing measured on the way but the last push; then as `take`. `floats` and `ints`
    are the cart's workspace."""
    d, (cart, flow) = unpack(block, plan), unpack_cart(floats, ints)
    given, room = d.room[:3], d.room[3:]
    stuck, room = room[: plan[5]], room[plan[5] :]
    count = math.ceil((end - begin) / MAX_FILTER_STEP - 1e-6)
    for i in range(count):
        step = (end - begin) / count
        time = begin + i * step
        if time - d.pushed[0] > WRENCH_HOLD_TIME:
            _let_go(d)
        raised(d.lift, d.push, given)
        point = Point(d.mean, time, d.theta, d.mean[:0])
        forward(cart, point, given, flow)
        n_stuck = stictions(cart, point, stuck) if plan[5] > 0 else 0
        _predict(d, flow, stuck[: 3 * n_stuck], plan[N_BLOCK_SIZES:], step, room)
        if _is_poised(d):
            settled = room[: len(d.poise)]
            settle_all(cart, point, situation(cart, point, lifted(cart.basis, d.mean[3:])), settled)
            _topple(d, settled)
    return _take(d, end, seen, felt, gate_ratio)


@entry
def predict(block: Array, plan: Indices, flow: Array, stuck: Array, step: float) -> bool:
    """`flow`: the rate (n,), its partials by state (n, n), wrench (n, 3) and parameters (n, p), one after the other;
    `stuck`: roots (3,) of densities of what Coulomb effects may give besides, one after the other. Returns whether a
    memory is poised."""
    d = unpack(block, plan)
    _predict(d, flow, stuck, plan[N_BLOCK_SIZES:], step, d.room)
    return _is_poised(d)


@entry
def take(block: Array, plan: Indices, time: float, seen: Array, felt: Array, gate_ratio: float) -> int:
    """What is `seen` (6,), a pose and a velocity, NaN where missing; then what is felt from now on, from the time of a
    sample on as in `measured_wrench.py`, or NaN. Returns how sensors do; `gate_ratio` is the ratio of the wrench's."""
    return _take(unpack(block, plan), time, seen, felt, gate_ratio)


@entry
def topple(block: Array, plan: Indices, settled: Array) -> None:
    """To where the memories (m,) settle."""
    _topple(unpack(block, plan), settled)


@compiled
def _let_go(d: Considered) -> None:
    """From now on the push may be any."""
    d.pushed[0] = d.pushed[1] = -math.inf
    d.push[:] = 0.0
    for a in range(len(d.push)):
        copy(d.unknown[a], d.push_covariance[a])


@compiled
def _predict(d: Considered, flow: Array, stuck: Array, free: Indices, step: float, room: Array) -> None:
    """The step is `(I - F h/2)⁻¹ h f` and the transition `(I - F h/2)⁻¹ (I + F h/2)`: of second order, and stable where
    F is stiff."""
    n, p, f, k = len(d.mean), len(d.theta), len(free), len(d.push)
    by_state = flow[n : n + n * n].reshape((n, n))
    by_wrench = flow[n + n * n : n * (4 + n)].reshape((n, 3))
    by_parameters = flow[n * (4 + n) : n * (4 + n + p)].reshape((n, p))
    half, room = carved(room, n, n)
    ahead, room = carved(room, n, n + 1 + f + k)
    for i in range(n):
        for j in range(n):
            half[i, j], ahead[i, j] = -0.5 * step * by_state[i, j], 0.5 * step * by_state[i, j]
        half[i, i], ahead[i, i] = 1.0 + half[i, i], 1.0 + ahead[i, i]
        ahead[i, n] = step * flow[i]
        for q in range(f):
            ahead[i, n + 1 + q] = step * by_parameters[i, free[q]]
        for a in range(k):
            value = 0.0
            for j in range(3):
                value += by_wrench[i, j] * d.lift[j, a]
            ahead[i, n + 1 + f + a] = step * value
    eliminate(half, ahead)
    noise, room = carved(room, n, n)
    _add_noise(d, by_wrench, stuck, 0.5 * step, noise, room)
    own, rest = carved(room, n, n)
    for i in range(n):
        for j in range(n):
            own[i, j] = d.own[i, j] + noise[i, j]
    add_congruence(ahead[:, :n], own, noise, rest)
    held = d.pushed[0] - d.pushed[1]
    shares = max((held if held < WRENCH_HOLD_TIME else WRENCH_HOLD_TIME) / step, 1.0)
    pushed, rest = carved(room, k, k)
    for a in range(k):
        for c in range(k):
            pushed[a, c] = shares * d.push_covariance[a, c]
    add_congruence(ahead[:, n + 1 + f :], pushed, noise, rest)
    moved, room = carved(room, n, f)
    for i in range(n):
        copy(d.slopes[i], moved[i])
        copy(noise[i], d.own[i])
        d.mean[i] += ahead[i, n]
    for i in range(n):
        copy(ahead[i, n + 1 :], d.slopes[i])
        for j in range(n):
            for q in range(f):
                d.slopes[i, q] += ahead[i, j] * moved[j, q]
    first = n - len(d.poise)
    for i in range(len(d.poise)):
        growth = by_state[first + i, first + i]
        d.poise[i] = d.poise[i] + growth * step if growth > 0 else 0.0


@compiled
def _add_noise(d: Considered, by_wrench: Array, stuck: Array, time: float, noise: Array, room: Array) -> None:
    """Puts into `noise` (n, n) what disturbances, stiction, slip and swivel add in a time."""
    disturbance, room = carved(room, 3, 3)
    for i in range(3):
        for j in range(3):
            disturbance[i, j] = time * d.disturbance[i, j]
            for c in range(len(stuck) // 3):
                disturbance[i, j] += time * stuck[3 * c + i] * stuck[3 * c + j]
    noise[:] = 0.0
    add_congruence(by_wrench, disturbance, noise, room)
    for i in range(len(noise)):
        noise[i, i] += time * d.rest[i]
    add_creep((math.cos(d.mean[2]), math.sin(d.mean[2])), d.creep, time, noise)


@compiled
def _is_poised(d: Considered) -> bool:
    longest = 0.0
    for a in range(len(d.poise)):
        longest = max(longest, d.poise[a])
    return longest > MAX_INSTABILITY_EFOLDINGS


@compiled
def _topple(d: Considered, settled: Array) -> None:
    """A caster doesn't stay turned against its way: a memory believed poised for too long is where it settles."""
    for a in range(len(d.poise)):
        if d.poise[a] > MAX_INSTABILITY_EFOLDINGS:
            i = len(d.mean) - len(d.poise) + a
            d.mean[i] = settled[a]
            d.slopes[i, :], d.own[i, :], d.own[:, i] = 0.0, 0.0, 0.0
            d.own[i, i] = d.spread[a] ** 2
            d.poise[a] = 0.0


@compiled
def _take(d: Considered, time: float, seen: Array, felt: Array, gate_ratio: float) -> int:
    believed, is_felt = Believed(d.mean, d.own, d.slopes, d.beside), math.isfinite(felt[0])
    d.nis[0] = take_pose(believed, seen[:3], d.variances[:3], d.room)
    d.nis[1] = take_velocity(believed, seen[3:], d.variances[3:], d.project, d.room)
    note(d.health[0], time, d.nis[0] / (3 * INNOVATION_GATE))
    note(d.health[1], time, d.nis[1] / (len(d.push) * INNOVATION_GATE))
    note(d.health[2], time, gate_ratio if is_felt else math.nan)
    if is_relocalised(d, time, seen, 3 * INNOVATION_GATE):
        restart_motion(d)
    if is_felt:
        push(d, time, felt)
    return said_of(d.health)


@compiled
def push(d: Considered, time: float, felt: Array) -> None:
    k = len(d.push)
    d.pushed[1], d.pushed[0] = d.pushed[0], time
    copy(felt[1:], d.push)
    for a in range(k):
        copy(felt[1 + k + k * a :], d.push_covariance[a])
