"""Simulations that start from a log's motion and run on with its wrenches: how far they are from it after a while."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.frames import Array, body_to_world, wrap_angle
from cartgrasp.model import CartModel
from cartgrasp.simulation.integrate import runge_kutta_4

from ...standstill import STANDSTILL_SPEED
from ...weak_form.balances import Balances
from .forced_motion import ForcedMotion

HORIZONS = (0.5, 1.0, 2.0)
"""Horizons of rollouts (s)."""
ROLLOUT_START_INTERVAL = 0.5
"""Time (s) between the starts of rollouts."""
MAX_ROLLOUT_STEP = 0.01
"""Step (s) of the integrator, where nothing is stiff."""
MAX_STABLE_STEP_RATE = 1.0
"""Largest product of a step and the fastest rate: inside the region where the integrator is stable."""
MAX_REST_FRACTION = 0.2
"""Largest share of a rollout's time at rest: where a cart stands longer, anything may have held it."""
DIVERGED_ERROR = 1e6
"""Way (m, rad) that a rollout has gone which has run away."""
STIFFNESS_SAMPLES = 40
"""States at which stiffness is looked at."""


@dataclass(frozen=True, eq=False)
class Rollouts:
    """Errors in {b} (starts, horizons, 3): m along and across, rad; NaN where a log ends before."""

    error: Array

    def gaps(self) -> Array:
        """Root mean square distance (horizons,), m."""
        return _root_mean((self.error[..., :2] ** 2).sum(axis=2))

    def by_coordinate(self) -> Array:
        """Root mean square errors (horizons, 3), m, m and rad."""
        return _root_mean(self.error**2)


def _root_mean(squares: Array) -> Array:
    """Root means over the starts that are known; NaN where none is."""
    known = np.ma.masked_invalid(squares)
    return np.asarray(np.sqrt(known.mean(axis=0).filled(np.nan)))


def starts(balances: Balances) -> np.ndarray:
    """Points of the grid from which a rollout stays where everything was seen, on the move."""
    motion, seen = balances.motion, balances.wrenches.seen
    last = round(HORIZONS[1] / motion.step)
    unseen = np.append(0, np.cumsum(~seen))
    first = np.arange(0, len(seen) - last, max(round(ROLLOUT_START_INTERVAL / motion.step), 1))
    stands = np.append(0, np.cumsum(balances.turning_speed < STANDSTILL_SPEED))
    moves = stands[first + last] - stands[first] < MAX_REST_FRACTION * last
    return np.asarray(first[(unseen[first + last] == unseen[first]) & moves])


def check_comparable(parts: Sequence[Balances]) -> None:
    """Refuses logs without a stretch from which a rollout begins: none would tell whether a model is right."""
    if not any(len(starts(balances)) for balances in parts):
        names = ", ".join(dict.fromkeys(balances.name for balances in parts))
        raise DataError(
            f"{names}: nowhere is the cart seen on the move, with all wrenches, for {HORIZONS[1]:g} s on end, so no "
            "simulation can be held against it; record it without gaps and pauses, or learn its numbers by "
            "`cartgrasp identify`"
        )


def rolled_out(
    balances: Balances,
    cart: CartModel,
    first: np.ndarray,
    driven: ForcedMotion | None = None,
    steps: np.ndarray | None = None,
) -> Array:
    """Poses (starts, horizons, 3) of a cart from points `first` on; NaN where the log ends before. It starts from the
    motion that it is `driven` along, by default as the log's forces make it; `steps` of the grid stand in place of the
    horizons'."""
    motion, side = balances.motion, balances.wrenches.planar(cart)
    driven = ForcedMotion.of(balances, cart) if driven is None else driven
    planar, state = cart.planar_wrench(driven.wrench), balances.state(cart)[first].copy()
    start = np.hstack([driven.pose, driven.velocity])[first]
    state[:, : start.shape[1]] = start
    begin = state[:, :3].copy()
    ends = (_steps(balances) if steps is None else steps).tolist()
    found = np.full((len(first), len(ends), 3), np.nan)
    seen = np.append(0, np.cumsum(~balances.wrenches.seen))
    step = _stable_step(balances, cart)
    parameters = np.broadcast_to(cart.parameters, (len(first), len(cart.parameters)))
    count = np.full(len(first), np.ceil(motion.step / step - 1e-9))
    at, after = (np.minimum(first + np.arange(k, k + ends[-1])[:, None], len(motion.time) - 1) for k in (0, 1))
    time, push = motion.time[at], (planar[at] + planar[after]) / 2
    if cart.is_compiled:
        states = cart.dynamics.driven((state, time[0], parameters), push, motion.step / count, count)
    else:  # effects from outside have no kernel
        states = _integrated(cart, state, time, push, motion.step)
    for k, moved in enumerate(states):
        if cart.slip_compliance:
            moved[:, :2] += _creep(cart, (state, time[k], parameters), side[at[k]]) * motion.step
        state = moved.copy()
        if k + 1 in ends:
            last = first + k + 1
            inside = last < len(motion.time)
            inside[inside] = seen[last[inside]] == seen[first[inside]]
            way = np.nan_to_num(state[inside, :3] - begin[inside], nan=DIVERGED_ERROR)
            found[inside, ends.index(k + 1)] = begin[inside] + np.clip(way, -DIVERGED_ERROR, DIVERGED_ERROR)
    return found


def rollouts(balances: Balances, cart: CartModel, first: np.ndarray) -> Rollouts:
    """Rollouts of a cart: how far they are from the log's smooth poses."""
    at = first[:, None] + _steps(balances)
    measured = balances.motion.of_body(cart).pose[np.minimum(at, len(balances.motion.time) - 1)]
    return Rollouts(_in_body(measured, rolled_out(balances, cart, first)))


def rollouts_beside(
    balances: Balances, cart: CartModel, others: Sequence[CartModel], first: np.ndarray
) -> list[Rollouts]:
    """Rollouts of other carts: how far they are from those of a cart."""
    own = rolled_out(balances, cart, first)
    return [Rollouts(_in_body(own, rolled_out(balances, other, first))) for other in others]


def noise_rollouts(
    balances: Balances, cart: CartModel, noise: Array, generator: np.random.Generator, n_draws: int
) -> Rollouts:
    """Rollouts of what noise of the motion's sensors, and white noise of the wrenches, (f,) N/√Hz, N·m/√Hz, do to a
    right model, drawn so many times."""
    first, own, found = starts(balances), ForcedMotion.of(balances, cart), []
    right, pose_std = rolled_out(balances, cart, first, own), balances.motion.pose_std
    for _ in range(n_draws):
        wrong = rolled_out(balances, cart, first, own.with_noise(noise, generator))
        found.append(_in_body(right, wrong + generator.standard_normal(right.shape) * pose_std))
    return Rollouts(np.concatenate(found))


def joined(parts: Sequence[Rollouts]) -> Rollouts:
    return Rollouts(np.concatenate([np.zeros((0, len(HORIZONS), 3)), *(one.error for one in parts)]))


def _steps(balances: Balances) -> np.ndarray:
    """Steps of the grid to each horizon."""
    return np.rint(np.array(HORIZONS) / balances.motion.step).astype(int)


def _in_body(true: Array, found: Array) -> Array:
    error = (body_to_world(true[..., 2]).mT @ (found - true)[..., None])[..., 0]
    error[..., 2] = wrap_angle(error[..., 2])
    return error


def _integrated(cart: CartModel, state: Array, time: Array, push: Array, step: float) -> Iterator[Array]:
    """States (r, n) after each of wrenches (k, r, 3) that are held for a step (s) from times (k, r) on."""
    for begin, held in zip(time, push, strict=True):
        state = runge_kutta_4(partial(_rate, cart, held), begin, state, step)
        yield state


def _rate(cart: CartModel, push: Array, time: Array, state: Array) -> Array:
    return cart.state_rate(state, push, time=time)


def _creep(cart: CartModel, point: tuple[Array, Array, Array], wrench: Array) -> Array:
    """What creeping wheels add to the velocity of the pose (r, 2)."""
    state, time, _ = point
    full = cart.state_rate(state, wrench, time=time)[:, :2]
    held = cart.dynamics.rate(point, wrench)[:, :2]
    return np.asarray(full - held)


def _stable_step(balances: Balances, cart: CartModel) -> float:
    """Step (s) that keeps what is stiff inside the region where the integrator is stable."""
    if not cart.memory_names:
        return MAX_ROLLOUT_STEP
    rows = np.linspace(0, len(balances.motion.time) - 1, STIFFNESS_SAMPLES).astype(int)
    planar = balances.wrenches.planar(cart)[rows]
    fastest = cart.stiffness(balances.state(cart)[rows], planar, balances.motion.time[rows])
    return MAX_STABLE_STEP_RATE / max(MAX_STABLE_STEP_RATE / MAX_ROLLOUT_STEP, fastest)
