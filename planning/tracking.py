"""From the error against a reference to the planar wrench that the cart should feel.

A cart with one rolling constraint has two inputs for three coordinates, so the lateral error is steered
(physics 12; correcting (26)-(28)): Kanayama's velocity law at the axle,

    u_c = u_d cos e_h + k_x e_x,    r_c = r_d + u_d k_y e_y sinc(e_h) + k_h e_h,

with e = (e_x, e_y) the position error along and across the wheels and e_h the heading error, then
`nu' = d/dt nu_c + k_v (nu_c - nu)` through reduced inverse dynamics. Lyapunov function
`(e_x² + e_y²)/2 + e_h²/(2 k_y)`: its rate is `-k_x e_x² - (k_h/k_y) e_h²`.
With no constraint all three coordinates are held, on a rail one: the same second-order error dynamics.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from cartgrasp.constraints import RollingConstraints
from cartgrasp.frames import Array, rotation_planar, wrap_angle
from cartgrasp.model import CartModel
from cartgrasp.motion import Motion, Reference


@dataclass(frozen=True)
class Gains:
    """Rates at which errors decay: along (1/s), across (1/m²), heading (1/s), velocity (1/s)."""

    along: float = 1.5
    across: float = 6.0
    heading: float = 3.0
    velocity: float = 5.0


@final
@dataclass(frozen=True)
class SteeringTracker:
    """For a cart with one rolling constraint."""

    gains: Gains = Gains()

    def wrench_b(self, reference: Reference, motion: Motion, model: CartModel) -> Array:
        rolling = model.rolling
        k = self.gains
        u, r = motion.velocity
        u_d, r_d = reference.velocity
        du_d, dr_d = reference.acceleration
        *position, e_h = _error_b(reference, motion, rolling.axle_x or 0.0)
        e_x, e_y = rotation_planar(rolling.angle).T @ position
        cosine, sine = np.cos(e_h), np.sin(e_h)
        e_x_rate = r * e_y - u + u_d * cosine
        e_y_rate = -r * e_x + u_d * sine
        e_h_rate = r_d - r
        sinc, sinc_slope = _sinc(e_h)
        u_c = u_d * cosine + k.along * e_x
        u_c_rate = du_d * cosine - u_d * sine * e_h_rate + k.along * e_x_rate
        r_c = r_d + k.across * u_d * e_y * sinc + k.heading * e_h
        r_c_rate = dr_d + k.heading * e_h_rate
        r_c_rate += k.across * (du_d * e_y * sinc + u_d * e_y_rate * sinc + u_d * e_y * sinc_slope * e_h_rate)
        acceleration = np.array([u_c_rate, r_c_rate]) + k.velocity * (np.array([u_c, r_c]) - motion.velocity)
        return _wrench(model, reference, motion, acceleration)


@final
@dataclass(frozen=True)
class DirectTracker:
    """For a cart whose every coordinate can be pushed: all casters, or a rail."""

    gains: Gains = Gains()

    def wrench_b(self, reference: Reference, motion: Motion, model: CartModel) -> Array:
        k = self.gains
        error = _error_b(reference, motion, 0.0)
        position = model.rolling.free_velocity(error)
        rate = reference.velocity - motion.velocity
        acceleration = reference.acceleration + (k.along + k.velocity) * rate + k.along * k.velocity * position
        return _wrench(model, reference, motion, acceleration)


def build_tracker(constraints: RollingConstraints, gains: Gains | None = None) -> SteeringTracker | DirectTracker:
    """The tracking law that suits the constraints."""
    gains = gains or Gains()
    return SteeringTracker(gains) if constraints.n_rows == 1 else DirectTracker(gains)


def _wrench(model: CartModel, reference: Reference, motion: Motion, acceleration: Array) -> Array:
    """Planar wrench in {b}. Friction is fed forward for the wanted velocity, so that it also breaks away from rest."""
    wanted = np.where(np.abs(reference.velocity) > 1e-3, reference.velocity, motion.velocity)
    state = model.state(motion.pose_sb, motion.velocity)
    feedforward = model.state(motion.pose_sb, wanted)
    reduced = model.required_wrench(state, acceleration, time=reference.time)
    drag = model.effect_wrench(state, time=reference.time) - model.effect_wrench(feedforward, time=reference.time)
    return model.planar_wrench(reduced + drag @ model.basis_b)


def _error_b(reference: Reference, motion: Motion, axle: float) -> Array:
    """Position error of the axle's middle in {b}, and heading error."""
    heading = wrap_angle(reference.pose_sb[2] - motion.pose_sb[2])
    there = reference.pose_sb[:2] + rotation_planar(reference.pose_sb[2])[:, 0] * axle
    here = motion.pose_sb[:2] + rotation_planar(motion.pose_sb[2])[:, 0] * axle
    position = rotation_planar(motion.pose_sb[2]).T @ (there - here)
    return np.array([*position, float(heading)])


def _sinc(angle: float) -> tuple[float, float]:
    """sin(a)/a and its derivative."""
    if abs(angle) < 1e-4:
        return 1.0 - angle**2 / 6, -angle / 3
    return float(np.sin(angle) / angle), float((angle * np.cos(angle) - np.sin(angle)) / angle**2)
