"""Motions that a person can ask of a cart, and what each would teach of its parameters (physics.md)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cartgrasp.frames import Array, body_to_world
from cartgrasp.information import WrenchNoise, fisher_information, parameter_regressor, reduced_noise
from cartgrasp.model import CartModel
from cartgrasp.motion import Estimate

MOTION_SAMPLE_PERIOD, MOTION_DURATION = 0.02, 12.0
MOTION_SPEED, MOTION_YAW_RATE = 0.5, 0.5
MAX_REMAINING_VARIANCE_RATIO = 0.8
"""Largest share of a simpler motion's variance that a better motion may leave."""
MAX_TOLD_VARIANCE_RATIO = 0.5
"""Share of the variance that a motion must leave less than to be told of at all."""
HANDLE_LEVER = 0.3
"""m: levers of two hands at a handle."""


@dataclass(frozen=True)
class ExcitingMotion:
    """`says` what to do; (u, w, r) in {b} over time (n, 3)."""

    says: str
    twist_b: Array

    def information(self, cart: CartModel, noise: WrenchNoise) -> Array:
        """Fisher information (p, p) of the cart's parameters, held by two hands with noisy wrenches."""
        velocity = cart.rolling.free_velocity(self.twist_b)
        acceleration = np.gradient(velocity, MOTION_SAMPLE_PERIOD, axis=0)
        pose = np.zeros((len(velocity), 3))
        for i in range(len(pose) - 1):
            pose[i + 1] = pose[i] + MOTION_SAMPLE_PERIOD * body_to_world(pose[i, 2]) @ cart.basis_b @ velocity[i]
        time = np.asarray(MOTION_SAMPLE_PERIOD * np.arange(len(pose)), dtype=float)
        memory = cart.memory_along(pose, velocity, time)
        regressor = parameter_regressor(cart, np.hstack([pose, velocity, memory]), acceleration)
        hands = [(-HANDLE_LEVER, HANDLE_LEVER, 1.0), (-HANDLE_LEVER, -HANDLE_LEVER, 1.0)]
        return fisher_information(regressor, reduced_noise(cart, hands, noise)) * noise.rate * MOTION_SAMPLE_PERIOD


def _motion(says: str, forward: ArrayLike = 0.0, aside: ArrayLike = 0.0, turning: ArrayLike = 0.0) -> ExcitingMotion:
    time = np.arange(0.0, MOTION_DURATION, MOTION_SAMPLE_PERIOD)
    return ExcitingMotion(says, np.stack([np.broadcast_to(part, time.shape) for part in (forward, aside, turning)], -1))


def exciting_motions() -> tuple[ExcitingMotion, ...]:
    """The motions, the simplest first."""
    time = np.arange(0.0, MOTION_DURATION, MOTION_SAMPLE_PERIOD)
    wave, other = np.sin(2 * np.pi * time / 3.0), np.sin(2 * np.pi * time / 4.4)
    slow = np.sin(2 * np.pi * time / MOTION_DURATION)
    return (
        _motion("roll straight at a steady speed", MOTION_SPEED),
        _motion("speed up and brake on a straight line, forwards", MOTION_SPEED * (0.6 + 0.4 * wave)),
        _motion("roll straight at several speeds, forwards and backwards", MOTION_SPEED * slow),
        _motion("push forwards and backwards on a straight line", MOTION_SPEED * wave),
        _motion("turn left and right on the spot", turning=MOTION_YAW_RATE * wave),
        _motion("drive a steady curve", MOTION_SPEED, turning=MOTION_YAW_RATE),
        _motion(
            "drive curves to both sides at a changing speed",
            MOTION_SPEED * (0.6 + 0.4 * wave),
            turning=MOTION_YAW_RATE * other,
        ),
        _motion("drive curves forwards and backwards", MOTION_SPEED * wave, turning=MOTION_YAW_RATE * other),
        _motion("push it sideways to and fro", aside=MOTION_SPEED * wave),
        _motion("push it sideways while it turns", aside=MOTION_SPEED * wave, turning=MOTION_YAW_RATE * other),
    )


def remedy(estimate: Estimate, free: np.ndarray, direction: Array, noise: WrenchNoise) -> str | None:
    """The motion after which the least would be left of the variance of `direction @ change of parameters`, (p,), those
    but the free ones being known; None where none leaves less than a half. Of alike ones, the simplest."""
    if estimate.covariance is None:
        return None
    cart, v, part = estimate.cart(), direction[free], np.ix_(free, free)
    known = np.linalg.inv(estimate.covariance[part])
    best, most = None, MAX_TOLD_VARIANCE_RATIO * float(v @ np.linalg.solve(known, v))
    for motion in exciting_motions():
        after = float(v @ np.linalg.solve(known + motion.information(cart, noise)[part], v))
        if after < most:
            best, most = motion.says, MAX_REMAINING_VARIANCE_RATIO * after
    return best
