"""The Cramér-Rao bound of a cart's parameters where the motion, too, is only measured.

Unknown are the parameters and the whole true motion: nu at each sample, and how far the cart has come. What wrenches,
poses and velocities are recorded is linear in small changes of both, so the information is that of least squares, with
the motion eliminated (Schur). Where motion sensors are exact it is that of `information.py`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import block_diag, csc_matrix, diags, hstack, kron, vstack
from scipy.sparse.linalg import splu

from ..frames import Array
from ..model import CartModel
from ..simulation.sensors import SensorNoise

KINEMATIC_STD = 1e-6
"""m or rad: how exactly the way is the integral of the velocity."""


@dataclass(frozen=True, eq=False)
class TrueMotion:
    """Poses (n, 3) and nu (n, f) at samples `period` (s) apart; which of the n - 1 wrenches between them are `used`."""

    pose: Array
    velocity: Array
    period: float
    used: np.ndarray


def information_of(cart: CartModel, motion: TrueMotion, wrench_noise: Array, sensors: SensorNoise) -> Array:
    """(p, p), of `cart.parameters`; `wrench_noise` (f, f) is that of the reduced wrench."""
    by_parameters, by_velocity = _wrench_rows(cart, motion, wrench_noise)
    rows = vstack([hstack([by_velocity, 0.0 * by_velocity]), _motion_rows(cart, motion, sensors)], format="csc")
    both = rows[: len(by_parameters)].T @ by_parameters
    return np.asarray(by_parameters.T @ by_parameters - both.T @ splu(csc_matrix(rows.T @ rows)).solve(both))


def _wrench_rows(cart: CartModel, motion: TrueMotion, noise: Array) -> tuple[Array, csc_matrix]:
    """What recorded wrenches change by, in their standard deviations: by parameters (m, p), and by nu (m, n f)."""
    n, f = motion.velocity.shape
    nu, pose = ((x[1:] + x[:-1]) / 2 for x in (motion.velocity, motion.pose))
    acceleration = np.diff(motion.velocity, axis=0) / motion.period
    memory = cart.memory_along(pose, nu, motion.period * np.arange(n - 1))
    found = cart.inverse(np.hstack([pose, nu, memory]), acceleration)
    white = np.linalg.inv(np.linalg.cholesky(noise))
    kept = np.flatnonzero(motion.used)
    by_mean, by_rate = (
        white @ part[kept] for part in (found.by_state[..., cart.velocity_slice], found.by_acceleration)
    )
    first, last = by_mean / 2 - by_rate / motion.period, by_mean / 2 + by_rate / motion.period
    at = f * kept[:, None] + np.arange(2 * f)
    rows = np.repeat(np.arange(f * len(kept)), 2 * f)
    columns = np.repeat(at, f, axis=0).ravel()
    values = np.concatenate([first, last], axis=2).ravel()
    by_velocity = csc_matrix((values, (rows, columns)), shape=(f * len(kept), n * f))
    return (white @ found.by_parameters[kept]).reshape(f * len(kept), -1), by_velocity


def _motion_rows(cart: CartModel, motion: TrueMotion, sensors: SensorNoise) -> csc_matrix:
    """Whitened rows of velocities, of poses, and of the constraint that ties the way to the velocity; their columns are
    nu and the way."""
    n, f = motion.velocity.shape
    s, one = sensors, np.eye(f)
    deviations = [s.linear_velocity, s.linear_velocity, s.yaw_rate], [s.position, s.position, s.heading]
    velocities, poses = (
        kron(diags([1.0], shape=(n, n)), np.diag(1.0 / np.array(std)) @ cart.basis_b) for std in deviations
    )
    mean = diags([0.5, 0.5], [0, 1], shape=(n - 1, n)) * -motion.period
    way = kron(diags([-1.0, 1.0], [0, 1], shape=(n - 1, n)), one)
    tied = hstack([kron(mean, one), way]) / KINEMATIC_STD
    return csc_matrix(vstack([block_diag([velocities, poses]), tied]))
