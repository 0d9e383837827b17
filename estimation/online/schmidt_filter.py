"""Pose, nu and effect memory as the recorded wrench drives them, parameters considered: `kernels/schmidt_steps.py`."""

from __future__ import annotations

import math
from typing import Self

import numpy as np

from cartgrasp.effects.effect import TYPICAL_MEMORY_SPREAD
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Motion
from cartgrasp.shallow_copy import shallow_copy

from ..gaussian import Gaussian
from ..health import empty_health_table
from ..noise import FilterNoise
from .first_motion import first_motion
from .kernels import schmidt_steps as kernels
from .kernels.jit import Indices
from .kernels.measured_wrench import WRENCH_HOLD_TIME
from .kernels.schmidt_block import Considered, new_block, parts
from .kernels.schmidt_steps import MAX_FILTER_STEP
from .kernels.sensor_health import noted
from .measured_motion import NO_MOTION, NO_WRENCHES

UNKNOWN_FORCE_STD = 100.0
"""N: of a wrench of which nothing is known."""


class SchmidtFilter:
    """What is believed of the state: `mean + slopes @ (parameters - theirs) ± own`, over `(pose, nu, memory)`."""

    def __init__(self, cart: CartModel, noise: FilterNoise, free: np.ndarray) -> None:
        self.cart, self._noise, self._free, self._nu = cart, noise, free, cart.velocity_slice
        self._in_kernels = cart.is_compiled and not cart.slip_compliance
        self._workspace = cart.dynamics.floats, cart.dynamics.ints
        self._sticks = not self._in_kernels or cart.dynamics.most_stictions > 0
        n, k, m = len(cart.state_names), cart.constraints.n_free, len(cart.memory_names)
        most = 3 * cart.dynamics.most_stictions if self._sticks else 0
        self._plan = np.array([n, k, m, len(cart.parameters), len(free), most, *free], np.int64)
        self._block = new_block(self._plan)
        self._now: Considered | None = None
        self.time, self.said = math.nan, 0  # of the last sample, and what it says of the sensors
        self._theta = self.now.theta[:] = cart.parameters
        self.now.health[:] = empty_health_table()
        self.now.outlier_run[-1] = -math.inf
        self._set_constants()
        self._let_go()

    def _set_constants(self) -> None:
        cart, noise, now = self.cart, self._noise, self.now
        now.unknown[:] = np.diag(noise.wrench_scale(cart) * UNKNOWN_FORCE_STD) ** 2
        now.lift[:] = cart.rolling.along_b.T
        now.project[:] = np.linalg.pinv(cart.basis_b)
        now.variances[:3], now.variances[3:] = np.diag(noise.pose_covariance), np.diag(noise.velocity_covariance)
        now.disturbance[:] = np.diag(np.array([1.0, 1.0, noise.lever]) * noise.disturbance) ** 2
        now.rest[2] = noise.slip**2
        now.rest[cart.memory_slice] = (noise.swivel * cart.memory_spread / TYPICAL_MEMORY_SPREAD) ** 2
        now.creep[:], now.spread[:] = noise.sideways(cart) * np.array(cart.rolling.across_b), cart.memory_spread

    @property
    def blocks(self) -> tuple[Array, Indices]:
        """The block and its plan, for kernels that call `drive`."""
        return self._block, self._plan

    @property
    def now(self) -> Considered:
        """Views of the block."""
        if self._now is None:
            self._now = parts(self._block, self._plan)
        return self._now

    @property
    def belief(self) -> Gaussian:
        """Mean and whole covariance."""
        now = self.now
        return Gaussian(now.mean.copy(), now.own + now.slopes @ now.beside @ now.slopes.T)

    def copy(self) -> Self:
        other = shallow_copy(self)
        other._block, other._now = self._block.copy(), None
        return other

    def scale_noise(self, noise_factors: Array) -> None:
        """Variances of velocities, linear and yaw (2,), are so many times the declared ones."""
        declared = np.diag(self._noise.velocity_covariance)
        self.now.variances[3:] = declared * noise_factors[[0, 0, 1]]

    def start(self, time: float, pose: Array) -> None:
        """From a pose that may be NaN in parts, with any velocity."""
        now = self.now
        now.mean[:], variances = first_motion(self.cart, self._noise, pose)
        now.own[:], now.slopes[:], now.nis[:] = np.diag(variances), 0.0, np.nan
        self._let_go()
        self.time = time
        if np.isfinite(pose).all():
            noted(now.health, time, np.array([0.0, math.nan, math.nan]))

    def coast(self, time: float) -> None:
        """Over a long gap: anything may have happened."""
        now = self.now
        now.own[:], now.slopes[:] = (1.0 + (time - self.time) ** 2) * np.eye(len(now.mean)), 0.0
        self._let_go()
        self.time = time

    @property
    def motion(self) -> Motion:
        mean = self._block[: self._plan[0]].copy()
        return Motion(mean[:3], mean[self._nu], mean[self.cart.memory_slice])

    def believe(self, theta: Array, covariance: Array) -> None:
        """Parameters (p,) and their covariance (p, p) are now believed to be others."""
        if theta is self._theta:
            return
        now, free = self.now, self._free
        now.mean[:] += now.slopes @ (theta - now.theta)[free]
        now.beside[:], now.theta[:] = covariance[np.ix_(free, free)], theta
        self._theta = theta

    def advance(self, time: float, seen: Array = NO_MOTION, felt: Array = NO_WRENCHES, gate_ratio: float = 0.0) -> None:
        """With nothing measured on the way but the last push; then takes in what is `seen` (6,) at that time: pose and
        velocity, NaN where missing; and what is `felt` from then on, from the time of a sample on as in
        `kernels/measured_wrench.py`, with its `gate_ratio`."""
        block, plan = self._block, self._plan
        if self._in_kernels:
            floats, ints = self._workspace
            self.said = kernels.drive(floats, ints, block, plan, self.time, time, seen, felt, gate_ratio)
        else:
            self._go(self.time, time)
            self.said = kernels.take(block, plan, time, seen, felt, gate_ratio)
        self.time = time

    def _go(self, begin: float, end: float) -> None:
        """What `kernels.drive` does, of effects without kernels."""
        cart, now = self.cart, self.now
        count = math.ceil((end - begin) / MAX_FILTER_STEP - 1e-6)
        for i in range(count):
            step = (end - begin) / count
            time = begin + i * step
            if time - now.pushed[0] > WRENCH_HOLD_TIME:
                self._let_go()
            rate = cart.rate(now.mean, now.lift @ now.push, now.theta, time)
            flow = np.concatenate(
                [part.ravel() for part in (rate.value, rate.by_state, rate.by_wrench, rate.by_parameters)]
            )
            stuck = cart.stiction(now.mean, now.theta, time).T.ravel() if self._sticks else np.zeros(0)
            if kernels.predict(self._block, self._plan, flow, stuck, step):
                kernels.topple(self._block, self._plan, cart.settled_memory(now.mean, now.theta, time))

    def _let_go(self) -> None:
        """From now on the push may be any."""
        now = self.now
        now.pushed[:] = -math.inf
        now.push[:], now.push_covariance[:] = 0.0, now.unknown
