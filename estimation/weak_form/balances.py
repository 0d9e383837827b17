"""Balances of momentum in weak form: of a log, linear in a cart's parameters.

Each balance is multiplied by a test function and integrated,

    ∫ φ (Sᵀ wrench_b - w(pose, nu, nu'; theta)) dt = noise,

with w the reduced wrench that the motion takes (physics.md). Test functions are cubic B-splines, a tenth of a second or
more apart. The motion's acceleration is the second derivative of a spline with twice their knots, so that the integral
is that of the recorded motion against their slope, whatever its noise: nothing is differentiated. Where an axle must
not go sideways, its speed across the wheels is one more balance.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.effects import ConstraintEffect, Effect, ForceScale, SensorEffect
from cartgrasp.effects.effect import Gate, InertiaEffect
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.logs import RunLog
from cartgrasp.model import CartModel

from ..log_noise.sample_step import usual_step
from ..noise import FilterNoise
from ..standstill import HALF_TRACK, STANDSTILL_SPEED
from .integrals import GRID_CHUNK_POINTS, Integrals
from .motion import KNOT_STEPS, Motion, motion_of
from .sensor_noise import noise_density
from .wheel_tracks import touches
from .wrenches import Densities, GridWrenches

POSE_STEP = 1e-4
"""Step (m, rad) of differences by {b}'s pose in the frame that is tracked."""
STILL_SPEED_SIGMAS = 2.0
"""Standard deviations of the smooth speed: a cart that seems to go slower may stand."""
REGION_RIM_WIDTH = 0.1
"""Rim (m) around a region of the floor: beyond, its soft edge is not felt."""


# Many methods: a log's rows, what any cart takes of them, and their noise, which share integrals that are costly.
# Half return the same rows with one thing changed.
@dataclass(frozen=True, eq=False)
class Balances:
    """Momentum balances of one log. Rows (k,) have one column per balance: the cart's free directions, then the speed
    across. The wrenches' noise has densities whose roots are known by arm (arms, 6), N/√Hz, N·m/√Hz, from sample to
    sample. What is `heard` in rows may be louder. The motion's noise enters with the body of a `reference`, so that
    models are compared by the same rows. Without one, it enters with the body of the cart that is asked about, in the
    residual and in its slopes."""

    name: str
    motion: Motion
    wrenches: GridWrenches
    log: RunLog
    wrench_densities: Array
    per_row: int
    told: FilterNoise | None = None
    samples_per_knot: float | None = None
    reference: CartModel | None = None
    heard: Densities | None = None

    @classmethod
    def of(
        cls, log: RunLog, cart: CartModel, told: FilterNoise | None = None, samples_per_knot: float | None = None
    ) -> Balances:
        """Rows a tenth of a second apart, of a motion as `motion_of` has it."""
        motion = motion_of(log, cart, told, samples_per_knot)
        late = [cart.lateness(arm) for arm in log.arms]
        wrenches, densities = GridWrenches.on(log, motion, late), wrench_densities(log, told)
        return cls(log.name, motion, wrenches, log, densities, 1, told, samples_per_knot).every(0.1)

    def every(self, row_step: float) -> Balances:
        """The same balances with test functions about `row_step` (s) apart: what is faster than half of its inverse is
        left out."""
        return replace(self, per_row=max(round(row_step / self.motion.step), KNOT_STEPS * 2))

    @property
    def row_step(self) -> float:
        return self.per_row * self.motion.step

    def beside(self, reference: CartModel | None, heard: Densities | None = None) -> Balances:
        """The same rows, with another reference and noise."""
        return self._with_same_rows(replace(self, reference=reference, heard=heard))

    def late(self, delay: ArrayLike) -> Balances:
        """The same rows with wrenches that were felt `delay` (s; of each arm, or of all) before they were recorded."""
        return self._with_same_rows(replace(self, wrenches=self.wrenches.late(self.log, delay)))

    def with_more_noise(self, cart: CartModel, generator: np.random.Generator) -> Balances:
        """The same rows with the noise of the motion's sensors added once more."""
        log, noise = self.log, self.motion.noise
        pose = log.pose + noise.pose * generator.standard_normal(log.pose.shape)
        velocity = log.velocity
        if velocity is not None and noise.velocity is not None:
            velocity = velocity + noise.velocity * generator.standard_normal(velocity.shape)
        noisy = replace(log, pose=pose, velocity=velocity)
        return self.along(motion_of(noisy, cart, self.told, self.samples_per_knot))

    def along(self, motion: Motion) -> Balances:
        """Balances of another motion on the same grid, with the rows of this one."""
        return self._with_same_rows(replace(self, motion=motion, wrenches=replace(self.wrenches, motion=motion)))

    def _with_same_rows(self, other: Balances) -> Balances:
        other.__dict__.update(integrals=self.integrals)
        return other

    def of_body(self, cart: CartModel) -> Balances:
        """Balances with {b} where a cart has it in the frame that was tracked."""
        motion = self.motion.of_body(cart)
        return self if motion is self.motion else self.along(motion)

    @property
    def _densities(self) -> Densities:
        return self.heard or Densities(self.wrench_densities, None)

    def _scale(self, cart: CartModel) -> float:
        """The mass relative to the reference's, where gains of sensors make a cart of any mass as likely; else 1."""
        if self.reference is None or not any(isinstance(effect, ForceScale) for effect, _ in cart.sensor_effects):
            return 1.0
        return cart.inertia.mass / self.reference.inertia.mass

    @property
    def turning_speed(self) -> Array:
        """How fast the cart and its wheels go (n,), m/s."""
        velocity = self.motion.velocity
        turning = np.abs(velocity[:, -1]) if velocity.shape[1] > 1 else 0.0
        return np.asarray(self.motion.speed + HALF_TRACK * turning)

    @property
    def still_speed(self) -> float:
        """Speed (m/s): a cart that seems to go slower may stand."""
        return float(np.hypot(STANDSTILL_SPEED, STILL_SPEED_SIGMAS * self.motion.rate_std[:2].max()))

    @cached_property
    def integrals(self) -> Integrals:
        """Integrals against test functions in whose support everything was seen and the cart moves: where it stands,
        anything may hold it. Where it stands throughout, all that was seen is used. How late sensors are changes
        nothing."""
        unseen = ~(self.wrenches.seen & self.wrenches.ahead)
        return Integrals.where(unseen, self.turning_speed > self.still_speed, self.per_row, self.motion.step)

    @property
    def used(self) -> np.ndarray:
        """Numbers (k,) of the test functions."""
        return self.integrals.used

    @property
    def time(self) -> Array:
        """Middles (k,) of the rows' test functions."""
        return np.asarray(self.motion.time[self.integrals.middles])

    def overlap(self, order: int, lag: int) -> float:
        """Overlap of two test functions' derivatives, as `Integrals` has it."""
        return self.integrals.overlap(order, lag)

    def integrated(self, signals: Array) -> Array:
        """Integrals (k, ...) of signals (n, ...) against the test functions."""
        return self.integrals.of(signals)

    @property
    def sample_step(self) -> float:
        """Usual step (s) of the samples of wrenches, of the arm whose come least often; of rows without an arm."""
        return max(_wrench_steps(self.log), default=0.0) or usual_step(self.log.time)

    def timing(self, cart: CartModel) -> Array:
        """What the residual (k, c) lacks for each second that wrenches are late."""
        rate = np.gradient(self.wrenches.planar(cart) @ cart.basis_b, self.motion.step, axis=0)
        return -self.integrated(self._on_all(rate))

    def lever(self, cart: CartModel, effect: Effect) -> Array:
        """What the residual (k, c, 1) lacks for each metre that a force effect of the cart acts to the left of where
        the model says."""
        beside = (e for e in cart.effects if isinstance(e, InertiaEffect | ConstraintEffect))
        alone, place = replace(cart, effects=(*beside, effect)), cart.constraints.n_free - 1
        state = self.of_body(cart)._state(alone)

        def moments(at: slice) -> Array:
            force = alone.effect_wrench(state[at], time=self.motion.time[at])[:, 0]
            return np.asarray(np.eye(self.n_balances(cart))[place] * force[:, None])

        return self.integrals.by_parts(moments, is_thin=True)[..., None]

    # --- balances ----------------------------------------------------------------------------------------------

    def n_balances(self, cart: CartModel) -> int:
        return cart.constraints.n_free + (cart.constraints.n_rows == 1)

    def state(self, cart: CartModel) -> Array:
        """State (n, s) of the cart along the motion."""
        return self.of_body(cart)._state(cart)

    def _state(self, cart: CartModel) -> Array:
        motion = self.motion
        return np.hstack([motion.pose, motion.velocity, motion.memory(cart)])

    def residual(self, cart: CartModel) -> tuple[Array, Array]:
        """Residual (k, c), and how much of it a unit of each parameter takes away (k, c, p)."""
        left, slopes = self._left(cart)
        for i in cart.pose_indices:
            slopes[..., i] = self._by_pose(cart, i, left)
        return left, slopes

    def _left(self, cart: CartModel) -> tuple[Array, Array]:
        """Residual and slopes as in `residual`, but for slopes by parameters that move {b} in the tracked frame."""
        own = self.of_body(cart)
        state = own._state(cart)
        rows = self.integrals.by_parts(lambda part: own._left_along(cart, state, part))
        return rows[..., 0], rows[..., 1:]

    def _left_along(self, cart: CartModel, state: Array, part: slice) -> Array:
        """Residual and slopes (points, c, 1 + p) along a part of this motion."""
        needed, by_parameters = self._needed(cart, state, part)
        planar = self.wrenches.planar(cart, part)
        left = planar @ cart.basis_b - needed
        acting = self._densities.scaled(self._scale(cart))
        slopes = by_parameters - self.wrenches.slopes(cart, needed, acting, part)
        found = np.concatenate([left[..., None], slopes], axis=2)
        share = self.wrenches.recorded_share(cart, self._densities, acting, part)
        found = self._on_all(found if share is None else share @ found)
        if self.motion.across is not None:
            found[:, -1, 0] = self.motion.across[part] - self.creep(cart, state[part], planar, self.motion.time[part])
        return found

    def _by_pose(self, cart: CartModel, i: int, left: Array) -> Array:
        """What a unit of the i-th parameter, which moves {b} in the tracked frame, takes of what is left (k, c)."""
        more = cart.with_parameters(cart.parameters + POSE_STEP * np.eye(len(cart.parameters))[i])
        return np.asarray((left - self._left(more)[0]) / POSE_STEP)

    def _on_all(self, wrenches: Array) -> Array:
        """Signals (n, f, ...) of the free directions in all balances (n, c, ...): the speed across has none of them."""
        none = np.zeros((len(wrenches), 0 if self.motion.across is None else 1, *wrenches.shape[2:]))
        return np.concatenate([wrenches, none], axis=1)

    def creep(self, cart: CartModel, state: Array, planar: Array, time: Array) -> Array:
        """Speed (n,) of the axle to {b}'s left that the cart's constraint effects make of a motion."""
        if not cart.constraint_effects:
            return np.zeros(len(state))
        axle, heading = float(cart.constraints.axle_x or 0.0), state[:, 2]
        x, y, yaw = cart.state_rate(state, planar, time=time)[:, :3].T
        return np.asarray(-np.sin(heading) * x + np.cos(heading) * y + axle * yaw)

    def columns(self, cart: CartModel, effect: Effect, share: Array | None = None) -> Array:
        """How much of the residual a unit of each parameter of one more effect takes away (k, c, q), a `share` (n,) of
        it at each time; of a constraint effect, its usual size (q = 1)."""
        if isinstance(effect, ConstraintEffect):
            return self._sideways(cart, effect)
        is_alone = not isinstance(effect, SensorEffect | InertiaEffect)  # then it depends on the body alone
        beside = tuple(e for e in cart.effects if isinstance(e, InertiaEffect)) if is_alone else cart.effects
        whole = replace(cart, effects=(*beside, effect))
        own, first = self.of_body(cart), len(whole.parameters) - len(effect.parameters)
        state = own._state(cart if isinstance(effect, SensorEffect) else whole)
        on = np.ones(len(state), dtype=bool)
        if effect.gate is Gate.INSIDE:  # or so near that its soft edge is felt
            on = touches(own.motion.pose, effect.values[:4], cart.wheel_set, REGION_RIM_WIDTH)

        def felt(part: slice) -> Array:
            return -own.wrenches.slopes(whole, own._needed(cart, state, part)[0], self._densities, part)[..., first:]

        def pushed(part: slice) -> Array:
            inside = on[part]
            at = np.arange(len(state))[part][inside]
            found = np.zeros((len(inside), cart.constraints.n_free, len(effect.parameters)))
            found[inside] = own._inverse(whole, state, at)[1][..., first:]
            return found if share is None else share[part, None, None] * found

        is_felt = isinstance(effect, SensorEffect)
        along = felt if is_felt else pushed
        slopes = self.integrals.by_parts(lambda part: self._on_all(along(part)), is_thin=not is_felt)
        if moved := [i for i in whole.pose_indices if i >= first]:
            left = self._left(whole)[0]
            for i in moved:
                slopes[..., i - first] = self._by_pose(whole, i, left)
        return slopes

    def between(self, one: CartModel, other: CartModel) -> Array:
        """How much more (k, c, 1) the motion takes of one cart than of another."""
        return self.integrated(self._on_all((self.expected(other) - self.expected(one))[..., None]))

    def taken(self, cart: CartModel) -> Array:
        """What a cart takes of all balances along the motion (n, c): of recorded wrenches what its sensors add, and of
        the speed across what its wheels creep."""
        planar, own = self.wrenches.planar(cart), self.of_body(cart)
        found = self._on_all(self.expected(cart) - planar @ cart.basis_b)
        if self.motion.across is not None:
            found[:, -1] = self.creep(cart, own._state(cart), planar, self.motion.time)
        return found

    def expected(self, cart: CartModel) -> Array:
        """The reduced wrench (n, f) that a cart's motion takes."""
        own = self.of_body(cart)
        state = own._state(cart)
        return np.concatenate([own._needed(cart, state, part)[0] for part in _chunks(len(state))])

    def _needed(self, cart: CartModel, state: Array, part: slice) -> tuple[Array, Array]:
        """The reduced wrench (points, f) and its slopes (points, f, p) by the parameters: along the smooth motion, and
        what the momentum of the reference's body has beside. Were that noise the cart's own, whatever makes a body
        lighter, or swings, would explain it (errors in variables; the smooth motion is the instrument)."""
        wrench, slopes = self._inverse(cart, state, part)
        if self.reference is not None:
            return wrench + self._scale(cart) * self._reference_noise[part], slopes
        noise, by_body = self._momentum_noise(cart, part)
        slopes[..., :N_PHI] += by_body
        return wrench + noise, slopes

    def _inverse(self, cart: CartModel, state: Array, at: slice | np.ndarray) -> tuple[Array, Array]:
        """The reduced wrench and its slopes along the smooth motion alone, of states at points of the grid."""
        return cart.inverse_by_parameters(state[at], self.motion.smooth_acceleration[at], time=self.motion.time[at])

    @cached_property
    def _reference_noise(self) -> Array:
        if self.reference is None:
            return np.zeros(0)
        parts = _chunks(len(self.motion.time))
        return np.concatenate([self._momentum_noise(self.reference, part)[0] for part in parts])

    def _momentum_noise(self, cart: CartModel, part: slice) -> tuple[Array, Array]:
        """The wrench, and its slopes, that a cart's body takes for the noise of the acceleration."""
        body, motion = replace(cart, effects=()), self.motion
        return body.inverse_by_parameters(body.state(), motion.acceleration[part] - motion.smooth_acceleration[part])

    def _sideways(self, cart: CartModel, effect: ConstraintEffect) -> Array:
        state, whole = self.state(cart), cart.with_effect(effect)
        across = np.eye(self.n_balances(cart))[-1]

        def aside(part: slice) -> Array:
            planar, time = self.wrenches.planar(cart, part), self.motion.time[part]
            more, less = (self.creep(each, state[part], planar, time) for each in (whole, cart))
            return np.asarray((more - less)[:, None] * across)

        return self.integrals.by_parts(aside)[..., None]


def _wrench_steps(log: RunLog) -> list[float]:
    """Usual step (s) of the samples of each arm's wrenches."""
    return [usual_step(log.time[np.isfinite(arm.wrench).all(axis=1)]) for arm in log.arms.values()]


def wrench_densities(log: RunLog, told: FilterNoise | None, averaged: Sequence[float] | None = None) -> Array:
    """Roots of the densities (arms, 6) of the wrenches' noise (N/√Hz, N·m/√Hz), by means over blocks (s)."""
    if told is not None:
        return np.asarray(np.sqrt(np.outer(_wrench_steps(log), np.diagonal(told.wrench_covariance)))).reshape(-1, 6)
    arms = [[noise_density(log.time, axis, averaged) for axis in arm.wrench.T] for arm in log.arms.values()]
    return np.array(arms).reshape(-1, 6)


def _chunks(count: int) -> Iterator[slice]:
    return (slice(first, first + GRID_CHUNK_POINTS) for first in range(0, count, GRID_CHUNK_POINTS))
