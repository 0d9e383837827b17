"""A cart's motion as a log's forces make it, held to what was measured: from there rollouts start. A smooth motion
can't follow forces that jump."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import cumulative_trapezoid

from cartgrasp.frames import Array, body_to_world
from cartgrasp.model import CartModel
from cartgrasp.tracked_point import composed, in_frame, inverted

from ...weak_form.balances import Balances


@dataclass(frozen=True, eq=False)
class ForcedMotion:
    """Poses (n, 3) and free velocities (n, f) of {b} along a log, with reduced wrenches (n, f). In {s}, of the tracked
    frame: its `known` rates (n, 3), which the cart gains from these, and its pose and rate, (n, 3) each, that keep to
    them with such penalties (3,)."""

    balances: Balances
    cart: CartModel
    wrench: Array
    pose: Array
    velocity: Array
    known: Array
    tracked: tuple[Array, Array]
    penalties: Array

    @classmethod
    def of(cls, balances: Balances, cart: CartModel) -> ForcedMotion:
        wrench = balances.wrenches.planar(cart) @ cart.basis_b
        known = _rate_s(balances, cart, wrench)
        pose, rate, penalties = balances.motion.fits.beside(known)
        return cls(balances, cart, wrench, *_of_body(cart, pose, rate), known, (pose, rate), penalties)

    def with_noise(self, density: Array, generator: np.random.Generator) -> ForcedMotion:
        """The same with the noise of the motion's sensors once more, and with white noise of the reduced wrench, by the
        root of its density (f,), N/√Hz, N·m/√Hz."""
        motion = self.balances.motion
        wrench = self.wrench + generator.standard_normal(self.wrench.shape) * density / motion.step**0.5
        known = _rate_s(self.balances, self.cart, wrench)
        more = motion.fits.noise_beside(known - self.known, self.penalties, generator)
        tracked = self.tracked[0] + more[0], self.tracked[1] + more[1]
        pose, velocity = _of_body(self.cart, *tracked)
        return replace(self, wrench=wrench, pose=pose, velocity=velocity, known=known, tracked=tracked)


def _rate_s(balances: Balances, cart: CartModel, wrench: Array) -> Array:
    """Rates (n, 3) of the tracked frame's pose in {s} that a cart gains from reduced wrenches (n, f); where these were
    not seen, as it went."""
    f, motion = cart.constraints.n_free, balances.of_body(cart).motion
    rate = cart.state_rate(balances.state(cart), cart.planar_wrench(wrench), time=motion.time)[:, 3 : 3 + f]
    rate = np.where(balances.wrenches.seen[:, None], rate, motion.smooth_acceleration)
    gained = cumulative_trapezoid(rate, motion.time, axis=0, initial=0) @ cart.basis_b.T
    back = inverted(cart.pose_tb)
    heading = motion.pose[:, 2] + back[2]
    return np.asarray((body_to_world(heading) @ (gained @ in_frame(back).T)[..., None])[..., 0])


def _of_body(cart: CartModel, pose: Array, rate: Array) -> tuple[Array, Array]:
    """Pose (n, 3) and free velocity (n, f) of {b}, from those of the tracked frame in {s}."""
    twist = (body_to_world(pose[:, 2]).mT @ rate[..., None])[..., 0]
    return composed(pose, cart.pose_tb), cart.rolling.free_velocity(twist @ in_frame(cart.pose_tb).T)
