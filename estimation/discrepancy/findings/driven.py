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
class Driven:
    """Poses (n, 3) and free velocities (n, f) of {b} along a log, with reduced wrenches (n, f)."""

    balances: Balances
    cart: CartModel
    wrench: Array
    pose: Array
    velocity: Array
    penalties: Array

    @classmethod
    def of(cls, balances: Balances, cart: CartModel) -> Driven:
        wrench = balances.wrenches.planar(cart) @ cart.basis_b
        pose, rate, penalties = balances.motion.fits.beside(_rate_s(balances, cart, wrench))
        return cls(balances, cart, wrench, *_of_body(cart, pose, rate), penalties)

    def with_noise(self, density: Array, generator: np.random.Generator) -> Driven:
        """The same with the noise of the motion's sensors once more, and with white noise of the reduced wrench, by the
        root of its density (f,), N/√Hz, N·m/√Hz."""
        fits, step = self.balances.motion.fits, self.balances.motion.step
        wrench = self.wrench + generator.standard_normal(self.wrench.shape) * density / step**0.5
        known, noisy = (_rate_s(self.balances, self.cart, one) for one in (self.wrench, wrench))
        pose, rate = fits.beside(known)[:2]
        more = fits.noise_beside(noisy - known, self.penalties, generator)
        own = _of_body(self.cart, pose + more[0], rate + more[1])
        return replace(self, wrench=wrench, pose=own[0], velocity=own[1])


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
