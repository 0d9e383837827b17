"""Pose, nu and effect memory as the recorded wrench drives them, parameters considered: `kernels/driven_motion.py`."""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from cartgrasp.effects.effect import USUAL_SPREAD
from cartgrasp.frames import Array
from cartgrasp.model import CartModel
from cartgrasp.motion import Motion

from .gaussian import Gaussian
from .kernels import driven_motion as kernels
from .noise import FilterNoise
from .wrench_sensing import SensedWrench

MAX_STEP = 0.01
HELD = 0.1
"""s: for how long a wrench is taken to go on."""
UNKNOWN_FORCE = 100.0
POISED = 12.0
"""e-foldings of an instability after which nothing is poised there any more."""
STICTION_MEMORY = 0.1
"""s: how long a stuck friction force keeps its value."""
NOTHING = np.full(3, np.nan)


@dataclass(frozen=True)
class Push:
    """A reduced wrench (k,) and the covariance of its noise (k, k), from a time (s) on, some `spacing` (s) after the
    one before."""

    time: float
    value: Array
    covariance: Array
    spacing: float


class DrivenMotion:
    """What is believed of the state: `mean + slopes @ (parameters - theirs) ± own`, over `(pose, nu, memory)`."""

    def __init__(self, cart: CartModel, noise: FilterNoise, free: np.ndarray) -> None:
        self.cart, self.noise, self._free = cart, noise, free
        n, k = len(cart.state_names), cart.constraints.n_free
        self.time, self.nis = math.nan, np.full(2, np.nan)
        self._mean, self._own, self._slopes = np.zeros(n), np.zeros((n, n)), np.zeros((n, len(free)))
        self._theta, self._beside = cart.parameters, np.zeros((len(free), len(free)))
        self._lift = np.ascontiguousarray(cart.planar_wrench(np.eye(k)).T)
        self._project = np.ascontiguousarray(np.linalg.pinv(cart.basis_b))
        self._variances = np.diag(noise.pose_covariance).copy(), np.diag(noise.velocity_covariance).copy()
        disturbance = np.array([1.0, 1.0, noise.lever]) * noise.disturbance
        roots = np.diag(disturbance)
        rest = np.zeros(n)
        rest[2] = noise.slip**2
        rest[cart.memory_slice] = (noise.swivel * cart.memory_spread / USUAL_SPREAD) ** 2
        self._disturbed = roots, rest, noise.sideways(cart) * np.array(cart.rolling.across_b, dtype=float)
        self._sticks = cart.stiction(cart.state(), cart.parameters, 0.0).shape[-1] > 0
        scale = {0: [1.0, 1.0, noise.lever], 1: [1.0, noise.lever], 2: [1.0]}[cart.constraints.n_rows]
        self._unknown = Push(-math.inf, np.zeros(k), np.diag(np.square(scale)) * UNKNOWN_FORCE**2, HELD)
        self._push = self._unknown
        self._poise = np.zeros(len(cart.memory_names))

    @property
    def belief(self) -> Gaussian:
        """Mean and whole covariance."""
        whole = self._own + self._slopes @ self._beside @ self._slopes.T
        return Gaussian(self._mean.copy(), whole)

    def copy(self) -> Self:
        other = copy.copy(self)
        other._mean, other._own, other._slopes = self._mean.copy(), self._own.copy(), self._slopes.copy()
        other.nis, other._poise = self.nis.copy(), self._poise.copy()
        return other

    def start(self, time: float, pose: Array) -> None:
        """From a pose that may be NaN in parts, with any velocity."""
        known, cart = np.isfinite(pose), self.cart
        self._mean = cart.state(np.where(known, pose, 0.0))
        variances = np.zeros(len(self._mean))
        variances[:3] = np.where(known, self._variances[0], 100.0)
        variances[cart.velocity_slice] = 1.0
        variances[cart.memory_slice] = cart.memory_spread**2
        self._own, self._slopes = np.diag(variances), np.zeros_like(self._slopes)
        self._push, self.time = self._unknown, time

    def coast(self, time: float) -> None:
        """Over a long gap: anything may have happened."""
        variance = 1.0 + (time - self.time) ** 2
        self._own, self._slopes = variance * np.eye(len(self._mean)), np.zeros_like(self._slopes)
        self._push, self.time = self._unknown, time

    @property
    def motion(self) -> Motion:
        return Motion(self._mean[:3].copy(), self._mean[self.cart.velocity_slice].copy())

    def learn(self, theta: Array, covariance: Array) -> None:
        """Parameters (p,) and their covariance (p, p) are now believed to be others."""
        if theta is self._theta:
            return
        self._mean += self._slopes @ (theta - self._theta)[self._free]
        self._theta, self._beside = theta, np.ascontiguousarray(covariance[np.ix_(self._free, self._free)])

    def advance(self, time: float) -> None:
        """With nothing measured but the last push."""
        gap = time - self.time
        n = math.ceil(gap / MAX_STEP - 1e-6)
        for i in range(n):
            self._step(self.time + i * gap / n, gap / n)
        self.time = time

    def take(self, pose: Array | None, velocity: Array | None) -> None:
        """Measured at the time that has come, NaN where missing."""
        seen = (
            NOTHING if pose is None else np.array(pose, dtype=float),
            NOTHING if velocity is None else np.array(velocity, dtype=float),
        )
        belief = self._mean, self._own, self._slopes
        kernels.take(belief, self._beside, seen, self._variances, self._project, self.nis)

    def push(self, wrench: SensedWrench) -> None:
        """From now on."""
        self._push = Push(self.time, wrench.value, wrench.covariance, min(self.time - self._push.time, HELD))

    def _step(self, time: float, step: float) -> None:
        cart, push = self.cart, self._push
        if time - push.time > HELD:
            push = self._unknown
        flow = cart.rate(self._mean, self._lift @ push.value, self._theta, time)
        roots, rest, creep = self._disturbed
        if self._sticks:
            stiction = cart.stiction(self._mean, self._theta, time)
            roots = np.hstack([roots, STICTION_MEMORY**0.5 * stiction])
        kernels.predict(
            (self._mean, self._own, self._slopes),
            (flow.value, flow.by_state, flow.by_parameters[:, self._free], flow.by_wrench),
            (roots, rest, creep),
            (self._lift, push.covariance * max(push.spacing / step, 1.0)),
            step,
        )
        if len(self._poise):
            self._note_poise(np.diagonal(flow.by_state)[cart.memory_slice], step)
            if (self._poise > POISED).any():
                self._topple(cart.settled_memory(self._mean, self._theta, time))

    def _note_poise(self, growth: Array, step: float) -> None:
        """Counts the e-foldings by which each memory has been unstable where it is believed to be."""
        self._poise = np.where(growth > 0, self._poise + growth * step, 0.0)

    def _topple(self, settled: Array) -> None:
        """A caster doesn't stay turned against its way: a memory believed poised for too long is where it settles."""
        for i in np.flatnonzero(self._poise > POISED):
            k = self.cart.memory_slice.start + i
            self._mean[k], self._slopes[k] = settled[i], 0.0
            self._own[k, :] = self._own[:, k] = 0.0
            self._own[k, k] = self.cart.memory_spread[i] ** 2
            self._poise[i] = 0.0
