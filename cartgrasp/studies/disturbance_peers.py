"""What others do about disturbances, as parts of the same controller: an extended-state observer, and the paper's law.

The observer is that of linear active disturbance rejection, which arXiv 2506.18410 (2026) pushes carts with: each free
direction is `nu' = b0 u + f` with f unknown, from poses alone, and `u = (u0 - f) / b0` (Gao 2003; Herbst 2021, arXiv
2011.01044). It learns no parameter; b0 is the first guess's. Its text was not at hand here, so its form is the standard
one, sampled with all poles at `exp(-bandwidth T)` (Miklosovic, Radke and Gao 2006).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from planning.tracking import Gains

from ..constraints import RollingConstraints
from ..contacts import ContactWrenches
from ..frames import Array, body_to_world, wrap_angle
from ..model import CartModel
from ..motion import Disturbance, Estimate, Measurement, Motion, Reference


class ExtendedStateObserver:
    """An `Estimator` of pose, nu and f, which it tells as a disturbance; `bandwidth` is in rad/s."""

    def __init__(self, guess: CartModel, bandwidth: float) -> None:
        self.cart, self.bandwidth = replace(guess, effects=()), bandwidth
        k = guess.constraints.n_free
        self._pose, self._nu, self._f = np.zeros(3), np.zeros(k), np.zeros(k)
        self._time, self._pushed = math.nan, np.zeros(3)
        still = self.cart.state()
        self._mass = np.array([self.cart.required_wrench(still, unit) for unit in np.eye(k)]).T

    def update(self, measurement: Measurement) -> Estimate:
        if measurement.pose is not None:
            self._see(measurement.time, np.asarray(measurement.pose))
        if measurement.wrenches:
            self._pushed = ContactWrenches(measurement.wrenches, measurement.contacts).wrench_b
        cart = self.cart
        told = Disturbance(self._mass @ self._f, np.zeros((len(self._f),) * 2))
        motion = Motion(self._pose.copy(), self._nu.copy())
        return Estimate(measurement.time, motion, {}, "ok", cart, cart.parameters, disturbance=told)

    def _see(self, time: float, pose: Array) -> None:
        if math.isnan(self._time):
            self._time, self._pose = time, pose.copy()
            return
        step, self._time, cart = time - self._time, time, self.cart
        rate = cart.state_rate(cart.state(self._pose, self._nu), self._pushed)[cart.velocity_slice] + self._f
        to_world = body_to_world(self._pose[2]) @ cart.basis_b
        self._pose = self._pose + step * to_world @ (self._nu + 0.5 * step * rate)
        self._nu = self._nu + step * rate
        off = pose - self._pose
        off[2] = wrap_angle(off[2])
        fade = math.exp(-self.bandwidth * step)
        along = cart.constraints.free_velocity(body_to_world(self._pose[2]).T @ off)
        self._pose = self._pose + (1.0 - fade**3) * off
        self._nu = self._nu + 1.5 * (1.0 - fade) ** 2 * (1.0 + fade) / step * along
        self._f = self._f + (1.0 - fade) ** 3 / step**2 * along


@dataclass(frozen=True)
class PaperTracker:
    """(26) with `u = -velocity M r` in (27): all three coordinates are tracked, whatever wheels forbid. `C q'` stands
    for `C (q_d' + alpha e)`, from which it differs by `C r`."""

    gains: Gains = Gains()

    def wrench_b(self, reference: Reference, motion: Motion, model: CartModel) -> Array:
        alpha, k = self.gains.along, self.gains.velocity
        free = replace(model, constraints=RollingConstraints(None))
        (velocity, wanted), (turned, ahead) = (
            [model.basis_b @ part.velocity for part in (motion, reference)],
            [body_to_world(part.pose_sb[2]) for part in (motion, reference)],
        )
        error = reference.pose_sb - motion.pose_sb
        error[2] = wrap_angle(error[2])
        error_rate = ahead @ wanted - turned @ velocity
        rate = model.basis_b @ reference.acceleration + wanted[2] * np.array([-wanted[1], wanted[0], 0.0])
        asked = ahead @ rate + (alpha + k) * error_rate + alpha * k * error
        asked_b = turned.T @ asked - velocity[2] * np.array([-velocity[1], velocity[0], 0.0])
        return free.required_wrench(free.state(motion.pose_sb, velocity), asked_b, time=reference.time)
