"""How far simulation goes astray: rollouts that start on the smoothed motion, pushed by the recorded wrenches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cartgrasp.compiled_dynamics import STABLE
from cartgrasp.frames import Array, wrap_angle
from cartgrasp.model import CartModel

from ..batch.smooth_motion import SmoothMotion
from ..batch.wrench_regression import WrenchRegression
from .fitted import Fitted
from .pushes import planar_wrench

STEP, SAMPLED = 0.005, 64
"""s: the integrator's longest; rows by which it is known how stiff a cart is."""
DRAWS = 4
"""Of noise: rollouts of a log are few."""
COORDINATES = ("forward", "sideways", "heading")
"""m, m, rad."""


@dataclass(frozen=True)
class Rollouts:
    """Errors (r, 3) at the end of rollouts that start at rows `first` (r,) and last `horizon` (s): along the cart,
    across it, and of its heading."""

    first: np.ndarray
    horizon: float
    error: Array

    @property
    def gap(self) -> float:
        """Root mean square of the distance, m; NaN of no rollouts."""
        return float(np.hypot(*self._root_mean_square[:2]))

    def closed(self, better: Rollouts) -> Array:
        """By how much the squared distance shrinks with another model, of each rollout (r,), m²."""
        return np.asarray((self.error[:, :2] ** 2 - better.error[:, :2] ** 2).sum(axis=1))

    @property
    def by_coordinate(self) -> dict[str, float]:
        return dict(zip(COORDINATES, self._root_mean_square.tolist(), strict=True))

    @property
    def _root_mean_square(self) -> Array:
        if not len(self.error):
            return np.full(len(COORDINATES), np.nan)
        return np.asarray(np.sqrt((self.error**2).mean(axis=0)), dtype=float)


def starts(regression: WrenchRegression, chosen: np.ndarray, horizon: float, every: float) -> np.ndarray:
    """Rows from which a rollout of `horizon` (s) stays on linked rows that have wrenches, within `chosen` (n,)."""
    time, usable = regression.motion.time, np.append(regression.usable, False)
    broken = np.append(0, np.cumsum(~usable))
    last = np.searchsorted(time, time + horizon - 1e-9)
    inside = last < len(time)
    last = np.minimum(last, len(time) - 1)
    outside = np.append(0, np.cumsum(~chosen))
    whole = inside & (broken[last] == broken[: len(time)]) & (outside[last] == outside[: len(time)])
    _, first = np.unique(np.where(whole, (time - time[0]) // every, -1), return_index=True)
    return np.asarray(first[whole[first]])


def roll_out(
    regression: WrenchRegression, cart: CartModel, delay: float, first: np.ndarray, horizon: float
) -> Rollouts:
    """Of a cart; `delay` is by what share of a step its recorded wrenches are late."""
    regression = regression.with_cart(cart)
    wrench, motion = _pushes(regression, cart, delay), regression.motion
    found = _ends(regression, cart, wrench, first, horizon, np.zeros((len(first), 3 + wrench.shape[1])))
    return Rollouts(first, horizon, _in_body(motion.pose[_last(regression, first, horizon)], found))


def noise_floor(
    regression: WrenchRegression, fitted: Fitted, first: np.ndarray, horizon: float, generator: np.random.Generator
) -> Rollouts:
    """What the noise of wrenches and of the smoothed motion alone would do to a perfect model; several draws of it."""
    cart = fitted.cart
    regression = regression.with_cart(cart)
    wrench, last = _pushes(regression, cart, 0.5), _last(regression, first, horizon)
    true = _ends(regression, cart, wrench, first, horizon, np.zeros((len(first), 3 + wrench.shape[1])))
    errors = []
    for _ in range(DRAWS):
        noise = _drawn_noise(regression, fitted.own_excess, generator)
        off = regression.motion.drawn_rows(generator)[:, : 3 + wrench.shape[1]]
        found = _ends(regression, cart, wrench + noise, first, horizon, off[first])
        found[:, :3] -= off[last, :3]
        errors.append(_in_body(true, found))
    return Rollouts(np.tile(first, DRAWS), horizon, np.concatenate(errors))


def _drawn_noise(regression: WrenchRegression, excess: float, generator: np.random.Generator) -> Array:
    """Of the reduced wrench (n, f), with its colour."""
    covariance = regression.wrench_covariance
    root = np.linalg.cholesky(excess * covariance + 1e-12 * np.eye(covariance.shape[1]))
    white, slow = generator.standard_normal((2, *covariance.shape[:2]))
    if regression.colour is not None:
        fade = np.exp(-np.diff(regression.motion.time) / regression.colour.time)
        for k, kept in enumerate(fade):
            slow[k + 1] = kept * slow[k] + np.sqrt(1 - kept**2) * slow[k + 1]
        white = np.sqrt(regression.colour.white) * white + np.sqrt(regression.colour.slow) * slow
    return np.asarray((root @ white[..., None])[..., 0])


def _in_body(true: Array, found: Array) -> Array:
    error = found - true
    cosine, sine = np.cos(true[:, 2]), np.sin(true[:, 2])
    along = cosine * error[:, 0] + sine * error[:, 1]
    across = -sine * error[:, 0] + cosine * error[:, 1]
    return np.stack([along, across, wrap_angle(error[:, 2])], axis=1)


def _pushes(regression: WrenchRegression, cart: CartModel, delay: float) -> Array:
    """Reduced wrenches (n, f) that act from a row to the next."""
    reduced = regression.reduced(cart)
    shift = 0.5 - delay
    neighbour = np.roll(reduced, -1 if shift >= 0 else 1, axis=0)
    return (1 - abs(shift)) * reduced + abs(shift) * neighbour


def _ends(
    regression: WrenchRegression, cart: CartModel, wrench: Array, first: np.ndarray, horizon: float, off: Array
) -> Array:
    """Poses (r, 3) after the horizon, from poses and velocities that are `off` (r, 3 + f)."""
    motion, f = regression.motion, wrench.shape[1]
    memory = cart.memory_along(motion.pose, motion.velocity, motion.time)
    state = np.hstack([motion.pose[first], motion.velocity[first], memory[first]])
    state[:, : 3 + f] += off
    planar, row = cart.planar_wrench(wrench), first.copy()
    side = planar_wrench(regression, cart) if cart.slip_compliance else planar
    last, step = _last(regression, first, horizon), _stable_step(cart, motion, memory, planar)
    while (active := np.flatnonzero(row < last)).size:
        at = row[active]
        steps = motion.time[at + 1] - motion.time[at]
        point = state[active], motion.time[at], np.broadcast_to(cart.parameters, (len(at), len(cart.parameters)))
        push = planar[at], np.ones((len(at), f))
        creep = _creep(cart, point, side[at]) * steps[:, None] if cart.slip_compliance else 0.0
        state[active] = cart.dynamics.advanced(point, push, *_divided(steps, step))
        state[active, :2] += creep
        row[active] += 1
    return state[:, :3]


def _last(regression: WrenchRegression, first: np.ndarray, horizon: float) -> np.ndarray:
    """Rows (r,) at which rollouts end."""
    time = regression.motion.time
    return np.asarray(np.searchsorted(time, time[first] + horizon - 1e-9))


def _creep(cart: CartModel, point: tuple[Array, Array, Array], wrench: Array) -> Array:
    """What creeping wheels add to the velocity of the pose, (r, 2)."""
    state, time, _ = point
    full = cart.state_rate(state, wrench, time=time)[:, :2]
    held = cart.dynamics.rate(point, (wrench, np.ones((len(state), cart.constraints.n_free))))[:, :2]
    return np.asarray(full - held)


def _divided(steps: Array, step: float) -> tuple[Array, Array]:
    count = np.ceil(steps / step - 1e-9)
    return steps / count, count


def _stable_step(cart: CartModel, motion: SmoothMotion, memory: Array, planar: Array) -> float:
    """That keeps swivels, which are stiff where they hardly turn, inside the region where the integrator is stable."""
    if not cart.memory_names:
        return STEP
    rows = np.linspace(0, len(motion.time) - 1, SAMPLED).astype(int)
    state = np.hstack([motion.pose, motion.velocity, memory])[rows]
    return STABLE / max(STABLE / STEP, cart.stiffness(state, planar[rows], motion.time[rows]))
