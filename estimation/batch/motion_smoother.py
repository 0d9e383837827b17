"""The motion of a log, from poses and velocities alone: a smoother with white jerk in the free directions.

States `(pose, nu, nu')` at the rows of the log; the most likely ones solve a chain of least squares, by Gauss-Newton
because headings turn what is measured. Wrenches stay out: what they are regressed on has then no share in their noise
(errors in variables, physics 11), and the smoothed motion is the mean of the true one given what was measured, so that
its errors do not bias a regression on it. How much jerk there is, the likelihood of the measurements tells; where a
jolt is seen, there is more. A single sample that is off is no jolt, and is left out: jerk that makes room for it would
be as wrong as the motion that follows it.
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

ROUNDS, SETTLED = 8, 1e-6
LONG_GAP = 0.3
"""s: across a longer one nothing is carried."""
PATH_FLOOR = 1e-6
"""m, rad: what a step's quadrature may miss."""
FIRST_JERK = 3.0
JERKS = 10.0 ** np.arange(-3.0, 3.5, 0.5)
"""m/s³ √s or rad/s³ √s: root densities that are tried."""
WINDOW = 0.25
"""s: jerk may be larger for as long as this, where a start or a jolt is seen."""
MISFITS, RAISE, RAISES = 4.0, 3.0, 6
"""Standard deviations by which residuals in a window may be too large; the factor that then raises the jerk there."""
OFF, CLEARINGS = 5.0, 3
"""Standard deviations from its neighbours beyond which a residual is off; rounds in which such samples are left out."""
MOST_OFF = 0.05
"""Of the samples: what happens more often is no accident."""
LOOSE = np.array([1e2, 1e1, 1e2])
"""Standard deviations of pose, nu and nu' before anything is measured."""


@dataclass(frozen=True)
class SmoothMotion:
    """At the rows of a log: pose (n, 3), nu (n, f), nu' (n, f), and the information about `(pose, nu, nu')` that the
    measurements hold (at every row, where these are `paired`), with what of it they tell row by row, `measured`
    (n, d, d). `linked` (n - 1,) says which neighbours belong together.
    """

    time: Array
    pose: Array
    velocity: Array
    acceleration: Array
    information: BlockTridiagonal
    measured: Array
    linked: np.ndarray
    jerk: Array

    @cached_property
    def velocity_std(self) -> Array:
        """Of nu (f,), in the middle of the log."""
        n, d, _ = self.information.diagonal.shape
        f = self.velocity.shape[1]
        one = np.zeros((n, d, f))
        one[n // 2, 3 : 3 + f] = np.eye(f)
        return np.sqrt(np.diagonal(self.information.factor().solve(one)[n // 2, 3 : 3 + f]))

    def drawn(self, generator: np.random.Generator) -> Array:
        """Errors of `(pose, nu, nu')` (n, d) at every row that the sensors' noise makes."""
        white = generator.standard_normal(self.measured.shape[:2])
        pull = (np.linalg.cholesky(self.measured) @ white[..., None])[..., 0]
        return self.information.factor().solve(pull)

    def drawn_rows(self, generator: np.random.Generator) -> Array:
        """The same at these rows."""
        n = len(self.time)
        size = len(self.measured) // n
        return np.asarray(self.drawn(generator)[: size * n].reshape(n, size, -1).mean(axis=1))

    @cached_property
    def noisier(self) -> SmoothMotion:
        """With as much noise of the sensors again."""
        parts = np.split(self.drawn_rows(np.random.default_rng(0)), [3, 3 + self.velocity.shape[1]], axis=1)
        pose, velocity, acceleration = (a + b for a, b in zip(self._parts, parts, strict=True))
        return replace(self, pose=pose, velocity=velocity, acceleration=acceleration)

    @property
    def _parts(self) -> tuple[Array, Array, Array]:
        return self.pose, self.velocity, self.acceleration

    @property
    def speed(self) -> Array:
        """Of {b}'s origin (n,), whatever way it goes."""
        return np.abs(self.velocity[:, 0]) if self.velocity.shape[1] < 3 else np.hypot(*self.velocity[:, :2].T)

    def paired(self) -> SmoothMotion:
        """Means of two rows each."""
        n = len(self.time) // 2
        columns = (self.time, self.pose, self.velocity, self.acceleration)
        time, pose, velocity, acceleration = ((c[: 2 * n : 2] + c[1 : 2 * n : 2]) / 2 for c in columns)
        whole, between = self.linked[: 2 * n - 1 : 2], self.linked[1 : 2 * n - 2 : 2]
        linked = whole[:-1] & between & whole[1:]
        rest = linked, self.jerk[: 2 * n - 2 : 2]
        return SmoothMotion(time, pose, velocity, acceleration, self.information, self.measured, *rest)

    @property
    def state(self) -> Array:
        return np.hstack(self._parts)


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
    jerk = np.tile(jerk, (max(len(log) - 1, 0), 1))
    state, information = _settle(chain, state, jerk)
    for _ in range(RAISES):
        jolted = _jolted(chain, state, log.time)
        if not jolted.any():
            break
        jerk[jolted] *= RAISE
        state, information = _settle(chain, state, jerk)
    pose, velocity, acceleration = np.split(state, [3, 3 + n_free], axis=1)
    measured = _measured(chain, state)[0].diagonal
    return SmoothMotion(log.time, pose, velocity, acceleration, information, measured, chain.linked, jerk)


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
    return _Chain(cart.basis_b, steps, steps < LONG_GAP, pose, log.velocity, noise, first, sideways)


def _settle(chain: _Chain, state: Array, jerk: Array) -> tuple[Array, BlockTridiagonal]:
    for _ in range(ROUNDS):
        information, gradient, _ = _normal(chain, state, jerk)
        move = information.factor().solve(gradient)
        state = state + move
        if np.abs(move).max() < SETTLED:
            break
    return state, _normal(chain, state, jerk)[0]


def _likeliest(chain: _Chain, state: Array, jerk: Array) -> Array:
    """Root densities (f,), one after the other, from a motion that is nearly right."""
    for i in range(len(jerk)):
        tried = [np.where(np.arange(len(jerk)) == i, value, jerk) for value in JERKS]
        jerk = min(tried, key=lambda one: _surprise(chain, state, one))
    return jerk


def _surprise(chain: _Chain, state: Array, jerk: Array) -> float:
    """-2 log of the likelihood of the measurements, but for what does not depend on the jerk."""
    information, gradient, cost = _normal(chain, state, jerk)
    factor: Factor = information.factor()
    explained = float((gradient * factor.solve(gradient)).sum())
    normaliser = 4.0 * float(np.log(jerk).sum()) * int(chain.linked.sum())  # q² is in the determinant of each step
    return cost - explained + factor.log_determinant + normaliser


def _normal(chain: _Chain, state: Array, jerk: Array) -> tuple[BlockTridiagonal, Array, float]:
    """Information, `-Jᵀ W residual` (n, d) and cost at a state."""
    seen, gradient, cost = _measured(chain, state)
    residual, first, second, weights = _steps(chain, state, jerk)
    weighted = (weights @ residual[..., None])[..., 0]
    gradient[:-1] -= np.einsum("nki,nk->ni", first, weighted)
    gradient[1:] -= np.einsum("nki,nk->ni", second, weighted)
    information = seen + BlockTridiagonal.of_pairs(first, second, weights)
    return information, gradient, cost + float((residual * weighted).sum())


def _measured(chain: _Chain, state: Array) -> tuple[BlockTridiagonal, Array, float]:
    n, d = state.shape
    n_free = chain.basis.shape[1]
    loose = np.repeat(LOOSE, [3, n_free, n_free]) ** -2.0
    information = BlockTridiagonal.zeros(n, d)
    diagonal = information.diagonal
    diagonal[:, range(d), range(d)] = loose
    gradient = -loose * (state - chain.first)
    cost = float((loose * (state - chain.first) ** 2).sum())
    for residual, weights, where in _sensors(chain, state):
        diagonal[:, where, where] += weights
        pull = (weights @ residual[..., None])[..., 0]
        gradient[:, where] += pull
        cost += float((residual * pull).sum())
    return information, gradient, cost


def _sensors(chain: _Chain, state: Array) -> list[tuple[Array, Array, slice]]:
    """Residuals (n, k), weights (n, k, k), and which part of the state they tell."""
    known = np.isfinite(chain.pose)
    residual = np.where(known, chain.pose - state[:, :3], 0.0)
    weights = known[:, :, None] * np.linalg.inv(chain.noise.pose_covariance)
    found = [(residual, weights, slice(0, 3))]
    if chain.velocity is not None:
        n_free = chain.basis.shape[1]
        to_free = np.linalg.pinv(chain.basis) @ np.swapaxes(body_to_world(state[:, 2]), 1, 2)
        whole: np.ndarray = np.asarray(np.isfinite(chain.velocity).all(axis=1))
        measured = (to_free @ np.where(whole[:, None], chain.velocity, 0.0)[..., None])[..., 0]
        covariance = to_free @ chain.noise.velocity_covariance @ np.swapaxes(to_free, 1, 2)
        residual = np.where(whole[:, None], measured - state[:, 3 : 3 + n_free], 0.0)
        found.append((residual, whole[:, None, None] * np.linalg.inv(covariance), slice(3, 3 + n_free)))
    return found


def _off(chain: _Chain, state: Array) -> np.ndarray:
    """Samples (n, 4) that are off as in `_Chain.without`: their residuals stand out from those around them."""
    found = np.zeros((len(state), 4), dtype=bool)
    for residual, weights, told in _sensors(chain, state):
        weight = np.diagonal(weights, axis1=1, axis2=2)
        for i, column in enumerate(np.where(weight > 0, residual * np.sqrt(weight), np.nan).T):
            own = outlying(column, OFF * max(1.0, MAD_TO_STD * usual_distance(column)))
            if own.mean() < MOST_OFF:
                found[:, min(told.start + i, 3)] |= own
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
