"""Whitened rows of a log: balances whose noise is as the sensors' own is known to be, up to a scale per balance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cholesky_banded
from scipy.linalg.lapack import dtbtrs

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from .balances import LEVER, STILL_SPEED, SUPPORT, Balances
from .motion import KNOT_STEPS

FORM_SHARE, EFFECT_SHARE = 0.01, 0.1
"""Of the root mean square wrench, and of what effects give at the time: what the forms of a body and of effects leave,
which neighbours share."""
G = 9.81
HELD = 0.1
"""Of the weight: what a hand or a chock holds at least."""
FRICTION = 0.01
"""Half of a usual coefficient of rolling resistance."""
MOMENT = 0.3
"""s: who turns back does not stand for as long."""
REST_SPEED, SWING_WAY = 0.05, 0.2
"""m/s, below which the paper learns nothing either; m, some four usual trails."""
BISECTIONS = 16
LEAST_FORCE, LEAST_SPEED = 1e-4, 1e-6
"""N/√Hz (N·m/√Hz), m/√Hz: keeps logs without any noise solvable."""


@dataclass(frozen=True, eq=False)
class Whitening:
    """Of a log's rows: the banded Cholesky factor of each balance's covariance, in LAPACK's lower form (c, SUPPORT,
    k)."""

    roots: tuple[Array, ...]

    @classmethod
    def of(cls, balances: Balances, cart: CartModel, excess: Array, unsure: Array | None = None) -> Whitening:
        """By white noise of wrenches and motion; `cart` tells how much of the motion's a balance takes in. `excess`
        (c,) is white noise beside the sensors' (N/√Hz, N·m/√Hz, m/s/√Hz), by which a model is wrong all the time;
        `unsure` (n, f) is what it may be off by at times, `model_error` unless given."""
        force, root_step = wrench_noise(balances, cart), balances.sample_step**0.5
        noise, free = balances.motion.noise, cart.constraints.n_free
        inertia = cart.inertia
        heavy = np.array([inertia.mass, inertia.mass, inertia.phi[3]])[[0, 1, 2] if free == 3 else [0, 2][:free]]
        own = [0, 1, 2] if free == 3 else [0, 2][:free]
        roots, unsure = [], model_error(balances, cart) if unsure is None else unsure
        for i in range(free):
            parts = [(float(np.hypot(force[i], excess[i])), 0)]
            if noise.velocity is not None:
                parts.append((heavy[i] * noise.velocity[own[i]] * root_step, 1))
            else:
                parts.append((heavy[i] * noise.pose[own[i]] * root_step, 2))
            roots.append(_root(balances, parts, unsure[:, i]))
        if balances.motion.across is not None:
            creep = float(np.hypot(LEAST_SPEED, excess[-1]))
            roots.append(_root(balances, [(noise.pose[0] * root_step, 1), (creep, 0)]))
        return cls(tuple(roots))

    def __call__(self, columns: Array) -> Array:
        """Columns (k, c, ...) whitened."""
        found = np.empty_like(columns)
        for i, root in enumerate(self.roots):
            flat = columns[:, i].reshape(len(columns), -1)
            found[:, i] = dtbtrs(root, flat, uplo="L")[0].reshape(columns[:, i].shape)
        return found


def model_error(balances: Balances, cart: CartModel) -> Array:
    """What a model may be off by (n, f), but for noise. Where the cart stands, anything may hold it. Near rest Coulomb
    friction takes whatever value holds things, and while casters swing round after a reversal nobody knows where they
    drag."""
    motion, free = balances.motion, cart.constraints.n_free
    speed = balances.turning_speed
    resting = np.exp(-((speed / REST_SPEED) ** 2))
    direction = np.sign(motion.velocity[:, 0])
    reversed_at = np.flatnonzero(np.diff(direction) != 0)
    last = np.searchsorted(reversed_at, np.arange(len(speed)) - 1, side="right") - 1
    since = np.where(
        last >= 0, motion.way - motion.way[reversed_at[np.maximum(last, 0)]] if len(reversed_at) else np.inf, np.inf
    )
    swinging = np.exp(-((since / SWING_WAY) ** 2))
    weight = FRICTION * G * cart.inertia.mass
    total = balances.wrenches.planar(cart) @ cart.basis_b
    size = np.sqrt((total**2).mean(axis=0))
    levers = np.array([1.0, 1.0, LEVER][:: 1 if free == 3 else 2][:free])
    held = np.exp(-((speed / STILL_SPEED) ** 2))[:, None] * np.hypot(size, HELD * G * cart.inertia.mass * levers)
    force, moment = weight * resting, weight * LEVER * np.maximum(resting, swinging)
    own = np.column_stack([force, force, moment][:: 1 if free == 3 else 2] if free > 1 else [force])
    effects = EFFECT_SHARE * np.abs(cart.effect_wrench(balances.state(cart), time=motion.time) @ cart.basis_b)
    return np.asarray(np.sqrt(own**2 + (FORM_SHARE * size) ** 2 + effects**2 + held**2))


def standing(balances: Balances, cart: CartModel) -> Array:
    """What holds a cart that stands for longer than a moment (n, f): anything may. One that only turns back is held by
    its drags alone, of which nobody sees when exactly they change their sign."""
    motion = balances.motion
    edges = np.flatnonzero(np.diff(np.r_[False, balances.turning_speed < balances.still_speed, False].astype(int)))
    found = np.zeros((len(motion.time), cart.constraints.n_free))
    total = balances.wrenches.planar(cart) @ cart.basis_b
    size = np.hypot(np.sqrt((total**2).mean(axis=0)), HELD * G * cart.inertia.mass)
    for first, last in edges.reshape(-1, 2):
        if (last - first) * motion.step > MOMENT:
            found[first:last] = size
    unseen = np.abs(motion.acceleration[:, 0]) * KNOT_STEPS * motion.step / 2 + motion.rate_std[:2].max()
    turning = np.exp(-((motion.velocity[:, 0] / np.maximum(unseen, LEAST_SPEED)) ** 2))
    levers = np.array([1.0, LEVER, LEVER])[: found.shape[1]]
    return np.asarray(np.hypot(found, FRICTION * G * cart.inertia.mass * turning[:, None] * levers))


def _root(balances: Balances, parts: list[tuple[float, int]], unsure: Array | None = None) -> Array:
    """Of the covariance of white noise, each part (the root of its density) through as many derivatives of the test
    functions, and of model errors (n,) that neighbours share."""
    k = len(balances.used)
    covariance = np.zeros((SUPPORT, k))
    for density, order in parts:
        for lag in range(min(SUPPORT, k)):
            overlap = balances.overlap(order, lag)
            linked = balances.used[lag:] - balances.used[: k - lag] == lag
            covariance[lag, : k - lag] += density**2 * overlap * linked
    if unsure is not None:
        off = balances.integrated(unsure)
        for lag in range(min(SUPPORT, k)):
            alike = balances.overlap(0, lag) / balances.overlap(0, 0)
            linked = balances.used[lag:] - balances.used[: k - lag] == lag
            covariance[lag, : k - lag] += alike * off[: k - lag] * off[lag:] * linked
    return np.asarray(cholesky_banded(covariance, lower=True))


def wrench_noise(balances: Balances, cart: CartModel) -> Array:
    """Root of the density of the reduced wrench's noise (f,), N/√Hz, N·m/√Hz."""
    variance = np.full(cart.constraints.n_free, LEAST_FORCE**2)
    for grasp, density in zip(balances.wrenches.grasps, balances.wrench_densities, strict=True):
        variance += ((np.abs(cart.basis_b.T @ grasp) * density) ** 2).sum(axis=2).mean(axis=0)
    return np.asarray(np.sqrt(variance))


def excess_noise(parts: Sequence[tuple[Balances, CartModel, Array]], used: float) -> Array:
    """White noise (c,) beside the sensors', as `Whitening.of` takes it, that makes residuals (k, c) of logs as large as
    they are; `used` parameters were fitted to them."""
    count = parts[0][2].shape[1]

    def surplus(excess: Array) -> Array:
        total, rows = np.zeros(count), 0
        for balances, cart, left in parts:
            total += (Whitening.of(balances, cart, excess)(left) ** 2).sum(axis=0)
            rows += len(left)
        return np.asarray(total / max(rows - used / count, 0.5 * rows))

    low, high = np.full(count, -6.0), np.full(count, 4.0)
    if (surplus(10.0**low) <= 1.0).all():
        return 10.0**low
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        too_small = surplus(10.0**middle) > 1.0
        low, high = np.where(too_small, middle, low), np.where(too_small, high, middle)
    return np.asarray(10.0**high)
