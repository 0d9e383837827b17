"""The augmented EKF over motion, effect memory, parameters and the pushing wrench, for wrenches that are nearly exact.

It is the augmented filter of (8)-(20), corrected as physics.md says: reduced dynamics with analytic partials instead
of the singular `M'`, an exponential step and Van Loan's process noise instead of Euler, Joseph's form, measured
velocities projected on the free directions. The reduced wrench `Sᵀ Σ G F` is a state with its own noisy measurement:
a noisy force used as an exact input biases the mass (errors in variables, physics 11). Inertia is carried in the
coordinates of `mobility.py`.

State: `(pose, nu, memory | free parameters | reduced wrench)`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from cartgrasp.effects.effect import USUAL_SPREAD
from cartgrasp.errors import UsageError
from cartgrasp.frames import Array, body_to_world, rotation_planar, wrap_angle
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate, Measurement, Motion
from cartgrasp.shallow import shallow

from ...gaussian import Gaussian
from ...health import SENSORS, Health, SensorHealth, by_sensor, no_health, said
from ...noise import FilterNoise
from ...parameter_report import as_taught
from ...prior import Prior
from ..first_motion import LOST_AFTER, UNKNOWN_FORCE, first_motion
from ..kernels.correction import GATE
from ..kernels.driven_motion import MAX_STEP, POISED
from ..kernels.felt_wrench import JUMP
from ..kernels.sensor_health import noted
from ..seen import usable
from ..wrench_sensing import Moving, WrenchSensing
from .filtering import exponential_step, innovation, predicted, updated
from .innovation_watch import InnovationWatch
from .parameter_block import ParameterBlock
from .wrench_walk import WrenchWalk

STANDS_OUT = 1.0
MEASUREMENT_FLOOR = 1e-10
BRIEFLY = 0.1
"""s: how long stiction keeps its value here, be it stuck for seconds: as white noise of that density it would drown
what changes faster."""


@dataclass(frozen=True)
class Layout:
    """Where the parts of the state stand."""

    motion: slice
    parameters: slice
    wrench: slice

    @classmethod
    def of(cls, cart: CartModel, n_free: int) -> Layout:
        n = len(cart.state_names)
        k = n + n_free
        return cls(slice(0, n), slice(n, k), slice(k, k + cart.constraints.n_free))


class AugmentedFilter:
    """Samples come in order. Noisy wrenches bias it, however small their walk is made."""

    def __init__(
        self,
        cart: CartModel,
        arms: Sequence[str] | None,
        noise: FilterNoise,
        prior: Prior,
        yaws: Mapping[str, float],
    ) -> None:
        self.cart, self.noise = cart, noise
        self._block = ParameterBlock(cart, prior)
        self.layout = Layout.of(cart, len(self._block.free))
        self._sensing = WrenchSensing(cart, arms, yaws, noise.wrench_covariance)
        self._watch = InnovationWatch()
        self._unknown_wrench = (noise.wrench_scale(cart) * UNKNOWN_FORCE) ** 2
        self._walk = WrenchWalk(self._unknown_wrench)
        self._poise = np.zeros(len(cart.memory_names))
        self._brief = math.sqrt(BRIEFLY) / cart.stiction_roots
        self._belief: Gaussian | None = None
        self._physical: tuple[Gaussian, Array] | None = None  # of a belief
        self._sensors, self._said = no_health(), 0
        self._loudness = np.eye(3)
        self.time = -math.inf
        self._started = self._has_wrench = False
        self._lift = cart.planar_wrench(np.eye(cart.constraints.n_free)).T
        self._project = np.linalg.pinv(cart.basis_b)

    worked: ClassVar[bool] = False

    def take(self, measurement: Measurement) -> None:
        """Predicts to the measurement's time, and takes in what it holds."""
        self._sensing.note_contacts(measurement)
        self._watch.last.clear()
        if not self._started:
            self._start(measurement)
        else:
            self._predict(measurement.time)
            if measurement.pose is not None:
                self._take_pose(usable(measurement.pose))
        if measurement.velocity is not None:
            self._take_velocity(usable(measurement.velocity))
        if measurement.wrenches:
            self._take_wrenches(measurement)
        if self._watch.wants_reset(self.time):
            self._open_load()
        found = [self._watch.last.get(name, (math.nan, 1)) for name in SENSORS]
        self._said = noted(self._sensors, measurement.time, np.array([nis / (GATE * size) for nis, size in found]))

    def hear(self, loudness: Array) -> None:
        """Variances of velocities, linear and yaw (2,), are so many times the declared ones."""
        self._loudness = np.diag(loudness[[0, 0, 1]])

    def copy(self) -> Self:
        other = shallow(self)
        other._watch, other._walk, other._sensing = self._watch.copy(), shallow(self._walk), self._sensing.copy()
        other._poise, other._sensors = self._poise.copy(), self._sensors.copy()
        return other

    def ahead(self, samples: Sequence[Measurement]) -> Self:
        """A copy that has seen later motion."""
        other = self.copy()
        for sample in samples:
            other.take(sample)
        return other

    @property
    def sensors(self) -> Mapping[str, SensorHealth]:
        return by_sensor(self._sensors)

    @property
    def belief(self) -> Gaussian:
        """Mean and covariance over the whole state."""
        if self._belief is None:
            raise UsageError("filter: no measurement has come yet")
        return self._belief

    @property
    def nis(self) -> Mapping[str, tuple[float, int]]:
        """Normalised innovation squared of the last measurement, with its dimension, by sensor."""
        return {name: found for name, found in self._watch.last.items() if name != "wrench"}

    def estimate(self) -> Estimate:
        mean, part = self.belief.mean, self.layout.parameters
        cart = self.cart
        motion = Motion(mean[:3].copy(), mean[cart.velocity_slice].copy(), mean[cart.memory_slice].copy())
        block = self._physical_block
        believed = self.belief.covariance[part, part]
        parameters = as_taught(self._block.report(block, believed), self._watch.health)
        theta, covariance = self._block.theta(block), self._block.model_covariance(block, believed)
        return Estimate(self.time, motion, parameters, self.health, self.cart, theta, covariance)

    @property
    def health(self) -> Health:
        own = self._watch.health if self._has_wrench else Health.NO_WRENCH
        return said(self._said, own)

    @property
    def _physical_block(self) -> Array:
        """The parameters to linearise at and to report. Where what is believed is no body, the belief itself stays as
        it is: pushed inside at every step, it would count each push as news."""
        belief, part = self.belief, self.layout.parameters
        if self._physical is None or self._physical[0] is not belief:
            self._physical = belief, self._block.nearest_physical(belief.mean[part], belief.covariance[part, part])
        return self._physical[1]

    # --- prediction ------------------------------------------------------------------------------------------

    def _start(self, measurement: Measurement) -> None:
        pose = np.full(3, np.nan) if measurement.pose is None else usable(measurement.pose)
        layout = self.layout
        mean, variances = np.zeros((2, layout.wrench.stop))
        mean[layout.motion], variances[layout.motion] = first_motion(self.cart, self.noise, pose)
        mean[layout.parameters] = self._block.first
        variances[layout.wrench] = self._unknown_wrench
        covariance = np.diag(variances)
        covariance[layout.parameters, layout.parameters] = self._block.first_covariance
        self._belief, self.time = Gaussian(mean, covariance), measurement.time
        self._started = bool(np.isfinite(pose[2]))  # without a heading nobody knows where anything pushes

    def _predict(self, time: float) -> None:
        gap = time - self.time
        if gap > LOST_AFTER:
            self._coast(gap)
        else:
            n = int(np.ceil(gap / MAX_STEP - 1e-6))
            for i in range(n):
                self._step(self.time + i * gap / n, gap / n)
        self.time = time

    def _step(self, time: float, step: float) -> None:
        belief, layout, cart = self.belief, self.layout, self.cart
        believed = belief.mean[layout.parameters]
        block = self._physical_block
        theta, wrench = self._block.theta(block), belief.mean[layout.wrench]
        wrench_b = self._lift @ wrench
        state = belief.mean[layout.motion]
        flow = cart.rate(state, wrench_b, theta, time, self._trust(wrench))
        n, rows = len(belief.mean), layout.motion
        rate, jacobian = np.zeros(n), np.zeros((n, n))
        rate[rows] = flow.value
        jacobian[rows, rows] = flow.by_state
        jacobian[rows, layout.parameters] = flow.by_parameters @ self._block.jacobian(block)
        jacobian[rows, layout.wrench] = flow.by_wrench @ self._lift
        where = range(layout.wrench.start, layout.wrench.stop)
        walk, fade = self._walk.at(time)
        rate[layout.wrench] = -fade * wrench
        jacobian[where, where] = -fade
        rate[rows] += jacobian[rows, layout.parameters] @ (believed - block)
        self._note_poise(np.diagonal(jacobian)[cart.memory_slice], step)
        stiction = cart.stiction(state, theta, time) * self._brief
        density = self._density(state[2], flow.by_wrench[cart.velocity_slice], stiction)
        advance = exponential_step(rate, jacobian, density, step)
        self._belief = predicted(belief, replace(advance, noise=advance.noise + self._walked(walk, step)))
        if (self._poise > POISED).any():
            self._topple(cart.settled_memory(state, theta, time))

    def _note_poise(self, growth: Array, step: float) -> None:
        """Counts the e-foldings by which each memory has been unstable where it is believed to be."""
        self._poise = np.where(growth > 0, self._poise + growth * step, 0.0)

    def _topple(self, settled: Array) -> None:
        """A caster doesn't stay turned against its way: a memory believed poised for too long is where it settles."""
        mean, covariance = self.belief.mean.copy(), self.belief.covariance.copy()
        for i in np.flatnonzero(self._poise > POISED):
            k = self.cart.memory_slice.start + i
            mean[k] = settled[i]
            covariance[k, :] = covariance[:, k] = 0.0
            covariance[k, k] = self.cart.memory_spread[i] ** 2
            self._poise[i] = 0.0
        self._belief = Gaussian(mean, covariance)

    def _trust(self, wrench: Array) -> Array:
        """How far each part of the wrench stands out of its noise, 0 to 1. Noise taken for a push, that moves nothing,
        would be evidence of an infinite inertia (errors in variables, physics 11)."""
        where = self.layout.wrench
        variance = np.diagonal(self.belief.covariance[where, where])
        return np.clip(1.0 - STANDS_OUT**2 * variance / np.maximum(wrench**2, 1e-300), 0.0, 1.0)

    def _density(self, heading: float, reach: Array, stiction: Array) -> Array:
        """Of the continuous process noise: disturbance force, stiction, slip, swivel."""
        n, noise, cart = self.layout.wrench.stop, self.noise, self.cart
        density = np.zeros((n, n))
        disturbance = np.array([1.0, 1.0, noise.lever]) * noise.disturbance
        roots = np.hstack([reach * disturbance, reach @ stiction])
        density[cart.velocity_slice, cart.velocity_slice] = roots @ roots.T
        sideways = rotation_planar(heading) @ cart.rolling.across_b
        density[:2, :2] = noise.sideways(cart) ** 2 * np.outer(sideways, sideways)
        density[2, 2] = noise.slip**2
        memory = range(cart.memory_slice.start, cart.memory_slice.stop)
        density[memory, memory] = (noise.swivel * cart.memory_spread / USUAL_SPREAD) ** 2
        return density

    def _walked(self, of_wrench: Array, step: float) -> Array:
        """Of the random walks that step between samples: parameters, and the held wrench."""
        n, layout = self.layout.wrench.stop, self.layout
        walk = np.zeros((n, n))
        walk[layout.parameters, layout.parameters] = self.noise.parameter_drift**2 * step * self._block.first_covariance
        wrench = range(layout.wrench.start, layout.wrench.stop)
        walk[wrench, wrench] = of_wrench * step
        return walk

    def _coast(self, gap: float) -> None:
        """Over a long gap in the log nothing is kept but the parameters: motion starts anew."""
        layout = self.layout
        covariance = self.belief.covariance.copy()
        for part in (layout.motion, layout.wrench):
            covariance[part, :] = covariance[:, part] = 0.0
        motion, wrench = range(layout.motion.stop), range(layout.wrench.start, layout.wrench.stop)
        covariance[motion, motion] = 1.0 + gap**2
        covariance[wrench, wrench] = self._unknown_wrench
        self._belief = Gaussian(self.belief.mean, covariance)
        self._watch.note_gap()

    # --- measurements ----------------------------------------------------------------------------------------

    def _take_pose(self, pose: Array) -> None:
        known = np.flatnonzero(np.isfinite(pose))
        if not len(known):
            return
        residual = pose - self.belief.mean[:3]
        residual[2] = wrap_angle(residual[2])
        H = np.zeros((len(known), self.layout.wrench.stop))
        H[range(len(known)), known] = 1.0
        self._absorb("pose", residual[known], H, self.noise.pose_covariance[np.ix_(known, known)], known)

    def _take_velocity(self, velocity: Array) -> None:
        if not np.isfinite(velocity).all():
            return
        to_free = self._project @ body_to_world(self.belief.mean[2]).T
        where = self.cart.velocity_slice
        H = np.zeros((self.cart.constraints.n_free, self.layout.wrench.stop))
        H[:, where] = np.eye(self.cart.constraints.n_free)
        R = to_free @ self._loudness @ self.noise.velocity_covariance @ to_free.T
        places = 3 + np.arange(self.cart.constraints.n_free)
        self._absorb("velocity", to_free @ velocity - self.belief.mean[where], H, R, places)

    def _take_wrenches(self, measurement: Measurement) -> None:
        layout = self.layout
        block = self._physical_block
        moving = Moving(self.belief.mean[layout.motion], measurement.time)
        sensed = self._sensing.sense(measurement, self._block.theta(block), moving)
        if sensed is None:
            return
        H = np.zeros((len(sensed.value), layout.wrench.stop))
        H[:, layout.wrench] = np.eye(len(sensed.value))
        H[:, layout.parameters] = -sensed.by_parameters @ self._block.jacobian(block)
        self._walk.note(measurement.time, sensed.value, np.diagonal(sensed.covariance))
        if not self._has_wrench:
            self._rest(sensed.covariance)
        self._follow_jump(sensed.value, sensed.covariance)
        self._absorb("wrench", sensed.value - self.belief.mean[layout.wrench], H, sensed.covariance)
        self._has_wrench = True

    def _rest(self, noise: Array) -> None:
        """Before the first wrench the arms are taken to rest, to within its noise, unless it is a jump from there."""
        mean, covariance, where = self.belief.mean.copy(), self.belief.covariance.copy(), self.layout.wrench
        covariance[where, :] = covariance[:, where] = mean[where] = 0.0
        covariance[where, where] = noise
        self._belief = Gaussian(mean, covariance)

    def _follow_jump(self, measured: Array, R: Array) -> None:
        """A step of the wrench (a regrasp, a switch of the controller) is followed at once, not walked to."""
        where = self.layout.wrench
        residual = measured - self.belief.mean[where]
        covariance = self.belief.covariance[where, where] + R + MEASUREMENT_FLOOR * np.eye(len(R))
        if residual @ np.linalg.solve(covariance, residual) < JUMP:
            return
        widened = self.belief.covariance.copy()
        widened[where, where] += np.outer(residual, residual)
        self._belief = Gaussian(self.belief.mean, widened)

    def _absorb(self, sensor: str, residual: Array, H: Array, R: Array, places: np.ndarray | None = None) -> None:
        """`places` of the innovation among those that have to be white: of pose and velocity, one after the other."""
        R = R + MEASUREMENT_FLOOR * np.eye(len(R))
        news = innovation(self.belief, residual, H, R)
        scale = self._watch.noise_scale(sensor, float(news.nis), len(residual))
        if scale > 1.0:
            R = scale * R
            news = innovation(self.belief, residual, H, R)
        elif places is not None:
            size = 3 + self.cart.constraints.n_free
            pull, variance = np.zeros(size), np.zeros((size, size))
            variance[np.ix_(places, places)] = np.linalg.inv(news.covariance)
            pull[places] = variance[np.ix_(places, places)] @ residual
            self._watch.note_news(self.time, pull, variance)
        self._belief = updated(self.belief, news, H, R)

    # --- parameters ------------------------------------------------------------------------------------------

    def _open_load(self) -> None:
        """The load may have changed: the parameters' covariance opens."""
        part = self.layout.parameters
        covariance = self.belief.covariance.copy()
        covariance[part, part] += self._block.load_covariance(self._physical_block)
        self._belief = Gaussian(self.belief.mean, covariance)
