"""The motion of a log, from poses and velocities alone: a smoother with white jerk in the free directions.

States `(pose, nu, nu')` at the rows of the log; the most likely ones solve a chain of least squares, by Gauss-Newton
because headings turn what is measured. Wrenches stay out: what they are regressed on has then no share in their noise
(errors in variables, physics 11), and the smoothed motion is the mean of the true one given what was measured, so that
its errors do not bias a regression on it. How much jerk there is, the likelihood of the measurements tells; where a
jolt is seen, there is more. A single sample that is off is no jolt, and is left out: jerk that makes room for it would
be as wrong as the motion that follows it. Where the pose's noise remembers (`pose_colour.py`), its slow part is a state
beside the motion.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cartgrasp.frames import Array, body_to_world
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from ..log_noise import MAD_TO_STD
from ..noise import FilterNoise
from ..outliers import outlying, usual_distance
from .block_tridiagonal import BlockTridiagonal, Factor
from .pose_colour import PoseColour, SlowNoise, colour_of_free_poses, colour_of_poses, gone_across
from .smooth_motion import SmoothMotion

ROUNDS, SETTLED = 8, 1e-6
LONG_GAP = 0.3
"""s: across a longer one nothing is carried."""
PATH_FLOOR = 1e-6
"""m, rad: what a step's quadrature may miss."""
FIRST_JERK = 3.0
JERKS = 10.0 ** np.arange(-3.0, 3.5, 0.5)[:, None]
"""m/s³ √s or rad/s³ √s: root densities that are tried."""
NEAR = 10.0 ** np.array([[-0.5], [0.0], [0.5]])
"""Times those that are near."""
SHARES = 2.0 ** np.arange(-1.5, 2.0, 0.5)
"""Times a first guess of slow noise: what is tried."""
COLOUR_WAYS = np.array([[0.0, 1.0, 0.0], [0.5, 0.5, 1.0], [1.0, 1.0, 0.0]])
"""Powers of these: of a position's and a heading's standard deviation and of the correlation time."""
WINDOW = 0.25
"""s: jerk may be larger for as long as this, where a start or a jolt is seen."""
MISFITS, RAISE, RAISES = 4.0, 3.0, 6
"""Standard deviations by which residuals in a window may be too large; the factor that then raises the jerk there."""
OFF, CLEARINGS = 5.0, 3
"""Standard deviations from its neighbours beyond which a residual is off; rounds in which such samples are left out."""
MOST_OFF = 0.05
"""Of the samples: what happens more often is no accident."""
CREEP, CREEP_BLOCK = 0.03, 0.5
"""m/s within so many seconds (s), root mean square: wheels that creep more across their heading are not said to roll,
or the smoother would make up speeds that explain it."""
LOOSE = np.array([1e2, 1e1, 1e2])
"""Standard deviations of pose, nu and nu' before anything is measured."""


@dataclass(frozen=True)
class _Chain:
    """What does not change between rounds."""

    basis: Array
    steps: Array
    linked: np.ndarray
    pose: Array
    velocity: Array | None
    noise: FilterNoise
    first: Array
    sideways: float
    slow: SlowNoise | None = None

    @property
    def size(self) -> int:
        """Of the motion's state; slow noise of the pose is behind it."""
        return 3 + 2 * int(self.basis.shape[1])

    @cached_property
    def pose_covariance(self) -> Array:
        """Of the white noise."""
        if self.slow is None:
            return self.noise.pose_covariance
        x, _, heading = np.sqrt(np.diagonal(self.noise.pose_covariance))
        white = self.slow.colour.white(np.array([x, heading]), float(np.median(self.steps)))
        return np.diag(white[[0, 0, 1]] ** 2)

    def coloured(self, colour: PoseColour) -> _Chain:
        first = np.hstack([self.first[:, : self.size], np.zeros((len(self.first), 3))])
        return replace(self, first=first, slow=SlowNoise.of(colour, self.steps, self.linked))

    def without(self, off: np.ndarray) -> _Chain:
        """But for the samples (n, 4) that are `off`: x, y, theta, and the velocity."""
        velocity = None if self.velocity is None else np.where(off[:, 3:], np.nan, self.velocity)
        return replace(self, pose=np.where(off[:, :3], np.nan, self.pose), velocity=velocity)


def smooth_motion(log: RunLog, cart: CartModel, noise: FilterNoise) -> SmoothMotion:
    """The most likely motion, with the jerk that the measurements make most likely."""
    chain = _chain(log, cart, noise)
    n_free = cart.constraints.n_free
    jerk = np.full(n_free, FIRST_JERK)
    state = _settle(chain, chain.first, jerk)[0]
    for _ in range(CLEARINGS):
        jerk = _likeliest(chain, state, jerk)
        state = _settle(chain, state, jerk)[0]
        off = _off(chain, state)
        if not off.any():
            break
        chain = chain.without(off)
    if chain.slow is not None:
        chain = _likelier(chain, state, jerk)
        state = _settle(chain, state, jerk)[0]
        jerk = _likeliest(chain, state, jerk, jerk * NEAR)
    jerk = np.tile(jerk, (max(len(log) - 1, 0), 1))
    state, information = _settle(chain, state, jerk)
    for _ in range(RAISES):
        jolted = _jolted(chain, state, log.time)
        if not jolted.any():
            break
        jerk[jolted] *= RAISE
        state, information = _settle(chain, state, jerk)
    pose, velocity, acceleration = np.split(state[:, : chain.size], [3, 3 + n_free], axis=1)
    measured = _measured(chain, state)[0].diagonal[:, : chain.size, : chain.size]
    return SmoothMotion(log.time, pose, velocity, acceleration, information, measured, chain.linked, jerk, chain.slow)


def _chain(log: RunLog, cart: CartModel, noise: FilterNoise) -> _Chain:
    pose = log.pose.copy()
    known = np.isfinite(pose[:, 2])
    pose[known, 2] = np.unwrap(pose[known, 2])
    first = np.zeros((len(log), 3 + 2 * cart.constraints.n_free))
    for i in range(3):
        seen = np.isfinite(pose[:, i])
        if seen.any():
            first[:, i] = np.interp(log.time, log.time[seen], pose[seen, i])
    steps = np.diff(log.time)
    sideways = noise.sideways(cart)
    chain = _Chain(cart.basis_b, steps, steps < LONG_GAP, pose, log.velocity, noise, first, sideways)
    whole = np.asarray(np.isfinite(pose).all(axis=1))
    axle, lever = cart.constraints.axle_x, noise.heading / noise.position
    if axle is None:
        colour = colour_of_free_poses(log.time[whole], first[whole, :2], lever)
    else:
        rolling = first[whole, :3] + [0.0, 0.0, np.arctan2(cart.basis_b[1, 0], cart.basis_b[0, 0])]
        creep = _creep(log.time[whole], rolling, axle)
        chain = replace(chain, sideways=float(np.hypot(sideways, creep)) if creep > CREEP else sideways)
        colour = colour_of_poses(log.time[whole], rolling, axle, lever)
    return chain if colour is None else chain.coloured(colour)


def _creep(time: Array, rolling: Array, axle: float) -> float:
    """Sideways speed (m/s), root mean square without the largest tenth."""
    first = np.flatnonzero(np.diff((time - time[:1]) // CREEP_BLOCK, prepend=-1.0))
    speed = np.diff(gone_across(rolling, axle)[first]) / np.diff(time[first])
    squares = np.sort(speed**2)[: int(np.ceil(0.9 * len(speed)))]
    return float(np.sqrt(squares.mean())) if len(squares) else 0.0


def _settle(chain: _Chain, state: Array, jerk: Array) -> tuple[Array, BlockTridiagonal]:
    for _ in range(ROUNDS):
        information, gradient, _ = _normal(chain, state, jerk)
        move = information.factor().solve(gradient)
        state = state + move
        if np.abs(move).max() < SETTLED:
            break
    return state, _normal(chain, state, jerk)[0]


def _likeliest(chain: _Chain, state: Array, jerk: Array, jerks: Array = JERKS) -> Array:
    """Root densities (f,) among `jerks` (k, 1) or (k, f), one after the other, from a motion that is nearly right."""
    for i in range(len(jerk)):
        tried = [np.where(np.arange(len(jerk)) == i, value, jerk) for value in jerks]
        jerk = min(tried, key=lambda one: _surprise(chain, state, one))
    return jerk


def _likelier(chain: _Chain, state: Array, jerk: Array) -> _Chain:
    """With the colour that the measurements make most likely, way by way."""
    for way in COLOUR_WAYS:
        assert chain.slow is not None
        tried = [chain.coloured(chain.slow.colour.times(share**way)) for share in SHARES]
        chain = min(tried, key=lambda one: _surprise(one, state, jerk))
    return chain


def _surprise(chain: _Chain, state: Array, jerk: Array) -> float:
    """-2 log of the likelihood of the measurements, but for what depends neither on the jerk nor on the colour."""
    information, gradient, cost = _normal(chain, state, jerk)
    factor: Factor = information.factor()
    explained = float((gradient * factor.solve(gradient)).sum())
    normaliser = 4.0 * float(np.log(jerk).sum()) * int(chain.linked.sum())  # q² is in the determinant of each step
    if chain.slow is not None:
        known = np.isfinite(chain.pose).sum(axis=0)
        normaliser += float((known * np.log(np.diagonal(chain.pose_covariance))).sum()) - chain.slow.log_determinant
    return cost - explained + factor.log_determinant + normaliser


def _normal(chain: _Chain, state: Array, jerk: Array) -> tuple[BlockTridiagonal, Array, float]:
    """Information, `-Jᵀ W residual` (n, d) and cost at a state."""
    information, gradient, cost = _measured(chain, state)
    size = chain.size
    residual, first, second, weights = _steps(chain, state[:, :size], jerk)
    weighted = (weights @ residual[..., None])[..., 0]
    gradient[:-1, :size] -= np.einsum("nki,nk->ni", first, weighted)
    gradient[1:, :size] -= np.einsum("nki,nk->ni", second, weighted)
    moved = BlockTridiagonal.of_pairs(first, second, weights)
    information.diagonal[:, :size, :size] += moved.diagonal
    information.below[:, :size, :size] += moved.below
    return information, gradient, cost + float((residual * weighted).sum())


def _measured(chain: _Chain, state: Array) -> tuple[BlockTridiagonal, Array, float]:
    n, d = state.shape
    n_free = chain.basis.shape[1]
    loose = np.append(np.repeat(LOOSE, [3, n_free, n_free]) ** -2.0, np.zeros(d - chain.size))
    information = BlockTridiagonal.zeros(n, d)
    diagonal = information.diagonal
    diagonal[:, range(d), range(d)] = loose
    gradient = -loose * (state - chain.first)
    cost = float((loose * (state - chain.first) ** 2).sum())
    if chain.slow is not None:
        cost += chain.slow.add_to(information, gradient, state[:, chain.size :])
    for residual, weights, parts in _sensors(chain, state):
        pull = (weights @ residual[..., None])[..., 0]
        cost += float((residual * pull).sum())
        for one in parts:
            gradient[:, one] += pull
            for other in parts:
                diagonal[:, one, other] += weights
    return information, gradient, cost


def _sensors(chain: _Chain, state: Array) -> list[tuple[Array, Array, list[slice]]]:
    """Residuals (n, k), weights (n, k, k), and which parts of the state they tell the sum of."""
    known = np.isfinite(chain.pose)
    parts = [slice(0, 3)] if chain.slow is None else [slice(0, 3), slice(chain.size, chain.size + 3)]
    residual = np.where(known, chain.pose - sum(state[:, part] for part in parts), 0.0)
    weights = known[:, :, None] * np.linalg.inv(chain.pose_covariance)
    found = [(residual, weights, parts)]
    if chain.velocity is not None:
        n_free = chain.basis.shape[1]
        to_free = np.linalg.pinv(chain.basis) @ np.swapaxes(body_to_world(state[:, 2]), 1, 2)
        whole: np.ndarray = np.asarray(np.isfinite(chain.velocity).all(axis=1))
        measured = (to_free @ np.where(whole[:, None], chain.velocity, 0.0)[..., None])[..., 0]
        covariance = to_free @ chain.noise.velocity_covariance @ np.swapaxes(to_free, 1, 2)
        residual = np.where(whole[:, None], measured - state[:, 3 : 3 + n_free], 0.0)
        found.append((residual, whole[:, None, None] * np.linalg.inv(covariance), [slice(3, 3 + n_free)]))
    return found


def _off(chain: _Chain, state: Array) -> np.ndarray:
    """Samples (n, 4) that are off as in `_Chain.without`: their residuals stand out from those around them."""
    found = np.zeros((len(state), 4), dtype=bool)
    for residual, weights, parts in _sensors(chain, state):
        weight = np.diagonal(weights, axis1=1, axis2=2)
        for i, column in enumerate(np.where(weight > 0, residual * np.sqrt(weight), np.nan).T):
            own = outlying(column, OFF * max(1.0, MAD_TO_STD * usual_distance(column)))
            if own.mean() < MOST_OFF:
                found[:, min(parts[0].start + i, 3)] |= own
    return found


def _jolted(chain: _Chain, state: Array, time: Array) -> np.ndarray:
    """Steps (n - 1,) in or beside windows in which the residuals are larger than their noise."""
    _, window = np.unique((time - time[0]) // WINDOW, return_inverse=True)
    squares, counts = np.zeros(window[-1] + 3), np.zeros(window[-1] + 3)
    for residual, weights, _ in _sensors(chain, state):
        np.add.at(squares, window + 1, (residual * (weights @ residual[..., None])[..., 0]).sum(axis=1))
        np.add.at(counts, window + 1, np.count_nonzero(residual, axis=1))
    too_large = squares > counts + MISFITS * np.sqrt(2 * counts)
    beside = too_large | np.roll(too_large, 1) | np.roll(too_large, -1)
    return np.asarray(beside[window[:-1] + 1])


def _steps(chain: _Chain, state: Array, jerk: Array) -> tuple[Array, Array, Array, Array]:
    """Residuals (n - 1, d) from one row to the next, partials by both, and weights.

    The path is Hermite's: `p1 - p0 = R(mean heading) S (h (nu0 + nu1) / 2 - h² (nu1' - nu0') / 12)`.
    """
    n_free, d = chain.basis.shape[1], state.shape[1]
    h = np.where(chain.linked, chain.steps, 1.0)[:, None]
    nu, rate = slice(3, 3 + n_free), slice(3 + n_free, d)
    before, after = state[:-1], state[1:]
    turn = body_to_world((before[:, 2] + after[:, 2]) / 2) @ chain.basis
    path = h * (before[:, nu] + after[:, nu]) / 2 - h**2 * (after[:, rate] - before[:, rate]) / 12
    travelled = (turn @ path[..., None])[..., 0]
    residual = np.concatenate(
        [
            after[:, :3] - before[:, :3] - travelled,
            after[:, nu] - before[:, nu] - h * before[:, rate],
            after[:, rate] - before[:, rate],
        ],
        axis=1,
    )
    first, second = np.zeros((len(h), d, d)), np.zeros((len(h), d, d))
    h = h[..., None]
    eye = np.eye(d)
    second[:], first[:] = eye, -eye
    first[:, nu, rate] = -h * np.eye(n_free)
    sideways = np.stack([-travelled[:, 1], travelled[:, 0]], axis=1)
    for partials, sign in ((first, -1.0), (second, 1.0)):
        partials[:, :2, 2] -= sideways / 2
        partials[:, :3, nu] = -h / 2 * turn
        partials[:, :3, rate] = sign * h**2 / 12 * turn
    weights = _step_weights(chain, before[:, 2], jerk) * chain.linked[:, None, None]
    return residual, first, second, weights


def _step_weights(chain: _Chain, heading: Array, jerk: Array) -> Array:
    n_free = chain.basis.shape[1]
    d, h = 3 + 2 * n_free, np.where(chain.linked, chain.steps, 1.0)
    weights = np.zeros((len(h), d, d))
    slip = chain.noise.slip**2 * h
    rolling = heading + np.arctan2(chain.basis[1, 0], chain.basis[0, 0])
    sideways = np.stack([-np.sin(rolling), np.cos(rolling)], axis=1)
    side = chain.sideways**2 * h
    creep = PATH_FLOOR**2 * np.eye(2) + side[:, None, None] * sideways[:, :, None] * sideways[:, None, :]
    weights[:, :2, :2] = np.linalg.inv(creep)
    weights[:, 2, 2] = 1 / (slip + PATH_FLOOR**2)
    for i in range(n_free):
        root = jerk[..., i]
        nu, rate = 3 + i, 3 + n_free + i
        weights[:, nu, nu] = 12 / (root**2 * h**3)
        weights[:, nu, rate] = weights[:, rate, nu] = -6 / (root**2 * h**2)
        weights[:, rate, rate] = 4 / (root**2 * h)
    return weights
