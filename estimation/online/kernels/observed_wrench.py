"""The steps of `disturbance/observer.py`, and the squares of `disturbance/disturbed_learning.py`, which say what they
are about. Beliefs are of pose, nu and d (n = 3 + 2 k,)."""

from __future__ import annotations

import math
from typing import NamedTuple

from cartgrasp.frames import Array
from cartgrasp.kernels import rigid_body
from cartgrasp.kernels.dynamics import Point, forward, inverse_by_parameters, lifted, rate_alone
from cartgrasp.kernels.workspace import copy
from cartgrasp.kernels.workspace import unpack as unpack_cart

from .correction import add_congruence, carved, normalised_square, put
from .free_directions import add_creep, raised
from .jit import Indices, compiled, entry

MAX_OBSERVER_STEP = 0.02
ROLLING_ROW, AGREED_ROW, WHOLE_ROW = 0, 1, 2
"""nu' of a cart that rolls on; what wrenches alone would make and is there; and what there is."""


class Constants(NamedTuple):
    """What lifts a reduced wrench to {b} (3, k), nu to a velocity in {b} (3, k), and that back (k, 3); covariances of
    pose and velocity (3, 3); the walk of d (k,), N per root of s, for the cart as it was made; variances of what may
    set in and inertias (k,); densities of disturbing wrenches (3,); creep along a direction (2,) of {b}; density of the
    heading's slip (1,); and the covariance (4, 4) of a usual load on a cart of 1 kg."""

    lift: Array
    basis: Array
    project: Array
    pose: Array
    velocity: Array
    walk: Array
    usual: Array
    inertias: Array
    disturbance: Array
    creep: Array
    slip: Array
    load: Array


def room_for(n_states: int, n_parameters: int, k: int) -> int:
    """How much room the entries need."""
    n = 3 + 2 * k
    return 8 * (n + 1) ** 2 + n_states * (2 + n_states + n_parameters) + 6 * k * (k + n_parameters + 4) + 60


@entry
def advance(
    floats: Array,
    ints: Indices,
    c: Constants,
    belief: tuple[Array, Array],
    push: tuple[Array, Array],
    known: tuple[Array, Array, float],
    span: tuple[float, float],
    room: Array,
) -> None:
    """Moves a belief over a span (s), pushed by a reduced wrench (k,) with the covariance of its noise; `known` are
    parameters (p,), what effects remember (m,), and the mass of the cart as it was made."""
    (mean, covariance), (theta, memory, made) = belief, known
    (cart, flow), k = unpack_cart(floats, ints), len(c.walk)
    state, rest = room[: 3 + k + len(memory)], room[3 + k + len(memory) :]
    given, reduced, rest = rest[:3], rest[3 : 3 + k], rest[3 + k :]
    copy(memory, state[3 + k :])
    begin, end = span
    count = math.ceil((end - begin) / MAX_OBSERVER_STEP - 1e-6)
    for i in range(count):
        step = (end - begin) / count
        copy(mean[: 3 + k], state[: 3 + k])
        for a in range(k):
            reduced[a] = push[0][a] + mean[3 + k + a]
        raised(c.lift, reduced, given)
        forward(cart, Point(state, begin + i * step, theta, theta[:0]), given, flow)
        _predict(c, (mean, covariance), push[1], flow, (len(state), step, theta[0] / made), rest)


@entry
def predict(
    c: Constants, belief: tuple[Array, Array], noise: Array, flow: Array, numbers: tuple[int, float, float], room: Array
) -> None:
    """One step whose flow comes from elsewhere; `numbers` as in `_predict`."""
    _predict(c, belief, noise, flow, numbers, room)


@compiled
def _predict(
    c: Constants, belief: tuple[Array, Array], noise: Array, flow: Array, numbers: tuple[int, float, float], room: Array
) -> None:
    """The exponential step with Van Loan's integral of the noise, by Simpson's rule. `flow`: the rate of the state, its
    partials by state and wrench, one after the other; `numbers`: how many states, the step (s), and the mass's share of
    what it was when the cart was made."""
    (mean, covariance), (n_states, step, share), k = belief, numbers, len(c.walk)
    n, moved = len(mean), 3 + k
    by_state = flow[n_states : n_states * (1 + n_states)].reshape((n_states, n_states))
    by_wrench = flow[n_states * (1 + n_states) : n_states * (4 + n_states)].reshape((n_states, 3))
    density, room = carved(room, n, n)
    half, room = carved(room, n + 1, n + 1)
    half[:], density[:] = 0.0, 0.0
    reach, rest = carved(room, moved, k)
    for i in range(moved):
        half[i, n] = flow[i]
        for j in range(moved):
            half[i, j] = by_state[i, j]
        for a in range(k):
            reach[i, a] = 0.0
            for j in range(3):
                reach[i, a] += by_wrench[i, j] * c.lift[j, a]
            half[i, moved + a] = reach[i, a]
    _add_density(c, by_wrench[:moved], mean[2], density)
    pushed, rest = carved(rest, k, k)
    for a in range(k):
        density[moved + a, moved + a] = (share * c.walk[a]) ** 2 * step
        for b in range(k):
            pushed[a, b] = noise[a, b] * step
    add_congruence(reach, pushed, density[:moved, :moved], rest)
    _exponential(half, 0.5 * step, room)
    whole, room = carved(room, n + 1, n + 1)
    _multiply(half, half, whole)
    total, room = carved(room, n, n)
    for i in range(n):
        for j in range(n):
            total[i, j] = step / 6.0 * density[i, j]
            density[i, j] *= step / 6.0
    add_congruence(whole[:n, :n], density, total, room)
    for i in range(n):
        for j in range(n):
            density[i, j] *= 4.0
    add_congruence(half[:n, :n], density, total, room)
    add_congruence(whole[:n, :n], covariance, total, room)
    for i in range(n):
        mean[i] += whole[i, n]
        copy(total[i], covariance[i])


@compiled
def _add_density(c: Constants, by_wrench: Array, heading: float, density: Array) -> None:
    """What white forces and wheels that creep do."""
    for i in range(len(by_wrench)):
        for j in range(len(by_wrench)):
            for a in range(3):
                density[i, j] += by_wrench[i, a] * c.disturbance[a] * by_wrench[j, a]
    add_creep((math.cos(heading), math.sin(heading)), c.creep, 1.0, density)
    density[2, 2] += c.slip[0]


@compiled
def _exponential(matrix: Array, step: float, room: Array) -> None:
    """`exp(matrix · step)` in its place, by scaling, a fourth-order Taylor step, and squaring; stiff decays stay
    decays."""
    n, largest = len(matrix), 0.0
    for i in range(n):
        row = 0.0
        for j in range(n):
            matrix[i, j] *= step
            row += abs(matrix[i, j])
        largest = max(largest, row)
    halvings = max(0, math.ceil(math.log2(largest + 1e-300)) + 2)
    scale = 1.0 / 2.0**halvings
    series, room = carved(room, n, n)
    product, _ = carved(room, n, n)
    for i in range(n):
        for j in range(n):
            matrix[i, j] *= scale
            series[i, j] = (1.0 if i == j else 0.0) + matrix[i, j] / 4.0
    for order in range(3, 0, -1):
        _multiply(matrix, series, product)
        for i in range(n):
            for j in range(n):
                series[i, j] = (1.0 if i == j else 0.0) + product[i, j] / order
    for _ in range(halvings):
        _multiply(series, series, product)
        for i in range(n):
            copy(product[i], series[i])
    for i in range(n):
        copy(series[i], matrix[i])


@compiled
def _multiply(left: Array, right: Array, product: Array) -> None:
    product[:] = 0.0
    for i in range(len(left)):
        for j in range(len(right)):
            value = left[i, j]
            if value != 0.0:
                for k in range(right.shape[1]):
                    product[i, k] += value * right[j, k]


@entry
def squares(
    floats: Array,
    ints: Indices,
    c: Constants,
    belief: tuple[Array, Array],
    given: Array,
    known: tuple[Array, Array, Array, Array, float],
    out: tuple[Array, Array],
    room: Array,
) -> tuple[float, float, float]:
    """Normalised squares of d: how little a usual load of a cart that rolls on explains it (`ROLLING_ROW`), one that
    makes what wrenches alone would make and is there (`AGREED_ROW`), and the same of a cart without effects. Into
    `found` (k, k) the covariance of d for what there is. `known` are parameters (p,), what is not known of them (p, p)
    or nothing, what effects remember (m,), what effects without a kernel add, and the time. `out`: rates (2, k), what
    nu' wrenches alone make, and with d, or NaN to be found here; and `found`."""
    (mean, covariance), (theta, unknown, memory, foreign, time), (rates, found) = belief, known, out
    (cart, flow), k = unpack_cart(floats, ints), len(c.walk)
    n_states = 3 + k + len(memory)
    state, room = room[:n_states], room[n_states:]
    copy(mean[: 3 + k], state[: 3 + k])
    copy(memory, state[3 + k :])
    point, d, told = Point(state, time, theta, foreign), mean[3 + k :], covariance[3 + k :, 3 + k :]
    if math.isnan(rates[0, 0]):
        push, reduced = room[:3], room[3 : 3 + k]
        for which in range(2):
            for a in range(k):
                reduced[a] = given[a] + (d[a] if which == 1 else 0.0)
            raised(c.lift, reduced, push)
            rate_alone(cart, point, push, flow)
            copy(flow[3 : 3 + k], rates[which])
    accelerations, room = carved(room, 3, k)
    _explained(rates, accelerations)
    by, room = carved(room, k, len(theta))
    wrench, room = room[:k], room[k:]
    mass, room = carved(room, k, k)
    load, room = carved(room, 4, 4)
    for i in range(4):
        for j in range(4):
            load[i, j] = c.load[i, j] * theta[0] ** 2
    rolls = agreed = rigid = 0.0
    for which in (ROLLING_ROW, AGREED_ROW, WHOLE_ROW):
        inverse_by_parameters(cart, point, accelerations[which], (wrench, mass, by))
        put(told, found)
        if len(unknown) > 0:
            add_congruence(by, unknown, found, room)
        if which == ROLLING_ROW:
            rolls = _square_beside_load(d, found, by[:, :4], load, room)
        elif which == AGREED_ROW:
            agreed = _square_beside_load(d, found, by[:, :4], load, room)
            _by_phi(cart.basis, state[3 : 3 + k], accelerations[which], by)
            rigid = _square_beside_load(d, found, by[:, :4], load, room)
    return rolls, agreed, rigid


@compiled
def _explained(rates: Array, accelerations: Array) -> None:
    """nu' (3, k) of a cart that rolls on, of what wrenches alone would make and is there, and of what there is."""
    for a in range(rates.shape[1]):
        alone, whole = rates[0, a], rates[1, a]
        least = alone if abs(alone) < abs(whole) else whole
        accelerations[ROLLING_ROW, a], accelerations[WHOLE_ROW, a] = 0.0, whole
        accelerations[AGREED_ROW, a] = least if alone * whole > 0.0 else 0.0


@compiled
def _square_beside_load(d: Array, known: Array, by: Array, load: Array, room: Array) -> float:
    """Normalised square of d (k,) known to (k, k), where a load (4, 4) may make some of it by (k, 4)."""
    total, room = carved(room, len(d), len(d))
    put(known, total)
    add_congruence(by, load, total, room)
    return normalised_square(d, total, room)


@compiled
def _by_phi(basis: Array, nu: Array, acceleration: Array, by: Array) -> None:
    """Partials of the reduced wrench by phi into the first of `by` (k, p), as if the cart had no effects."""
    rows = rigid_body.regressor(lifted(basis, nu), lifted(basis, acceleration))
    for a in range(len(nu)):
        for j in range(4):
            by[a, j] = 0.0
            for i in range(3):
                by[a, j] += basis[i, a] * rows[i][j]
