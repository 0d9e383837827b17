"""Rows of the filtered regression: both sides of the reduced dynamics through `F = rate / (s + rate)`, once a block.

The wrench is `Mr nu' + g(nu)`, and Mr is constant in the body frame (physics 4), so that no velocity is differentiated:
`F[Mr nu'] = Mr rate (nu - F[nu])`. Successive values of a filter share their noise. What is new after a block of T,
`F_k - exp(-rate T) F_(k-1)`, is an integral over the block alone,

    B[x] = ∫ rate exp(-rate (t_k - s)) x(s) ds,    B[nu'] = rate (nu_k - exp(-rate T) nu_(k-1) - B[nu]),

whose wrench noise no other block has; what is wrong with nu_k stands in two neighbours with unlike signs.

Noise in B[nu'] is in a row's slopes and in its residual alike (errors in variables, physics 11). So slopes are worked
out at a part of B[nu'] that stands out of its noise, and what their correlation with the residual pulls on average,
which Stein's lemma `E[g(x + e) e] = E[g'(x + e)] var e` gives, is told with the row.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..noise import FilterNoise
from ..wrench_sensing import SensedWrench
from .motion_tracker import Stretch

RATE = 2.0
"""1/s, of the filter."""
STILL = 3.0
"""Standard deviations of nu within which a cart may stand still."""
FLOOR_SHARE = 0.002
"""Of the wrench: what a model leaves out."""
STANDS_OUT = 2.0
"""Standard deviations of B[nu'] that teach nothing."""
NOISE_SHARE = 0.75
"""Of the variance of a smoothed nu: what is noise of sensors, and not motion that was smoothed away; a half where
there are poses alone."""


@dataclass(frozen=True)
class Weights:
    """Of the block's integral: for a function that is linear between instants (n,), and for one held (n - 1,)."""

    linear: Array
    held: Array
    fade: float

    @classmethod
    def of(cls, time: Array) -> Weights:
        h = np.diff(time)
        gain = -np.expm1(-RATE * h)
        left = np.exp(-RATE * (time[-1] - time[1:]))
        second = 1.0 - gain / (RATE * h)
        linear = np.append(left * (gain - second), 0.0)
        linear[1:] += left * second
        return cls(linear, left * gain, float(np.exp(-RATE * (time[-1] - time[0]))))


class Recorded(NamedTuple):
    """The sensed reduced wrench of a moment, worked out at `parameters` (p,); `time` is its sample's, which may be some
    moments old."""

    time: float
    sensed: SensedWrench
    parameters: Array


@dataclass(frozen=True)
class FilteredRow:
    """`residual = slopes @ (change of theta | lateness) + ends @ (e_k - fade e_(k-1)) + noise`, with e what is wrong
    with nu, of covariance `before` and `after`. `feigned` (p + 1,) is what noise in the slopes adds to the mean of
    `slopesᵀ W residual`."""

    residual: Array
    slopes: Array
    ends: Array
    fade: float
    noise: Array
    before: Array
    after: Array
    feigned: Array


@dataclass(frozen=True)
class Rise:
    """B[nu'] (f,), with covariance (f, f); the part of it that stands out of its noise, with derivative (f,)."""

    whole: Array
    covariance: Array
    part: Array
    derivative: Array

    @classmethod
    def of(cls, whole: Array, covariance: Array) -> Rise:
        square = STANDS_OUT**2 * np.diagonal(covariance) / np.maximum(whole**2, 1e-300)
        seen = square < 1.0
        return cls(whole, covariance, np.where(seen, (1 - square) * whole, 0.0), np.where(seen, 1 + square, 0.0))

    def feigned(self, by_acceleration: Array, mass: Array, noise: Array) -> Array:
        """(p,), from the slopes' partials by B[nu'] (f, f, p), the mass matrix and the rest of a row's noise (f, f)."""
        weight = np.linalg.inv(noise + mass @ self.covariance @ mass.T)
        through = (self.derivative[:, None] * self.covariance) @ mass.T @ weight
        return np.asarray(-NOISE_SHARE * np.einsum("ij,ijp->p", through, by_acceleration))


def stands_still(motion: Stretch) -> bool:
    """Whether nothing is seen to move, all the block long."""
    variance = np.diagonal(motion.velocity_covariance, axis1=1, axis2=2)
    return bool((motion.velocity**2 < STILL**2 * variance).all())


def least_speed_in(motion: Stretch, cart: CartModel) -> float:
    """Of {b}'s origin, the smallest in the block, m/s."""
    return float(np.linalg.norm((motion.velocity @ cart.basis_b.T)[:, :2], axis=1).min())


def filtered_row(
    cart: CartModel, parameters: Array, motion: Stretch, memory: Array, recorded: Sequence[Recorded], noise: FilterNoise
) -> FilteredRow:
    """The row of a block around parameters (p,); memory is (n, k), and each wrench is held to the next moment."""
    weights = Weights.of(motion.time)
    state = np.hstack([motion.pose, motion.velocity, memory])
    rest = cart.inverse(state, np.zeros_like(motion.velocity), parameters, motion.time)
    f = motion.velocity.shape[1]
    change = motion.velocity[-1] - weights.fade * motion.velocity[0] - weights.linear @ motion.velocity
    before, after = motion.velocity_covariance[[0, -1]]
    rise = Rise.of(RATE * change, RATE**2 * (after + weights.fade**2 * before))
    asked = np.vstack([np.zeros(f), rise.part, np.eye(f)])
    moved = cart.inverse(np.tile(state[-1], (f + 2, 1)), asked, parameters, motion.time[-1])
    mass, by_acceleration = moved.by_acceleration[0], moved.by_parameters[2:] - moved.by_parameters[0]
    expected = weights.linear @ rest.wrench + mass @ rise.whole
    by_parameters = np.tensordot(weights.linear, rest.by_parameters, 1)
    by_parameters = by_parameters + moved.by_parameters[1] - moved.by_parameters[0]
    whole = rest.wrench + motion.acceleration @ mass.T
    step = float(np.diff(motion.time).mean())
    late = step * RATE * (whole[-1] - weights.fade * whole[0] - expected)
    measured, measured_by = _measured(parameters, recorded, weights)
    own = _noise(cart, recorded, weights, noise) + _stuck(cart, state, parameters, motion, weights)
    return FilteredRow(
        residual=measured - expected,
        slopes=np.column_stack([by_parameters - measured_by, late]),
        ends=-RATE * mass,
        fade=weights.fade,
        noise=own,
        before=before,
        after=after,
        feigned=np.append(rise.feigned(by_acceleration, mass, own), 0.0),
    )


def curvature_noise(cart: CartModel, parameters: Array, motion: Stretch, memory: Array, spread: Array) -> Array:
    """Covariance (f, f) of what a row that is linear in the parameters leaves out, where they are known to within
    `spread @ z`, (p, q), with standard normal z: `tr(T T) / 2` of `zᵀ T z / 2`. Load times friction is not linear."""
    k = len(motion.time) // 2
    state = np.concatenate([motion.pose[k], motion.velocity[k], memory[k]])
    around = parameters + np.vstack([np.zeros(len(parameters)), spread.T])
    rows = np.tile(state, (len(around), 1))
    by = cart.inverse(rows, np.tile(motion.acceleration[k], (len(around), 1)), around, motion.time[k]).by_parameters
    twist = (by[1:] - by[0]) @ spread
    gain = -np.expm1(-RATE * (motion.time[-1] - motion.time[0]))
    return np.asarray(gain**2 / 2 * np.einsum("qfr,qgr->fg", twist, twist))


def _measured(parameters: Array, recorded: Sequence[Recorded], weights: Weights) -> tuple[Array, Array]:
    """B of the wrenches (f,), and its partials (f, p)."""
    by = np.array([one.sensed.by_parameters for one in recorded])
    change = np.array([parameters - one.parameters for one in recorded])
    values = np.array([one.sensed.value for one in recorded]) + np.einsum("nfp,np->nf", by, change)
    return weights.held @ values, np.tensordot(weights.held, by, 1)


def _noise(cart: CartModel, recorded: Sequence[Recorded], weights: Weights, noise: FilterNoise) -> Array:
    """Of sensors, a sample that stands for several moments counted whole; of disturbances; and a floor."""
    f = cart.constraints.n_free
    total = np.zeros((f, f))
    _, sample = np.unique([one.time for one in recorded], return_inverse=True)
    shares = np.bincount(sample, weights.held)
    for share, i in zip(shares, np.unique(sample, return_index=True)[1], strict=True):
        total += share**2 * recorded[i].sensed.covariance
    disturbance = cart.basis_b.T @ np.diag([1.0, 1.0, noise.lever]) * noise.disturbance
    total += RATE / 2 * (1 - weights.fade**2) * disturbance @ disturbance.T
    size = weights.held @ np.abs([one.sensed.value for one in recorded])
    return np.asarray(total + np.diag(FLOOR_SHARE * size) ** 2 + 1e-10 * np.eye(f))


def _stuck(cart: CartModel, state: Array, parameters: Array, motion: Stretch, weights: Weights) -> Array:
    """Of Coulomb forces where the cart may stand still, for all that nu tells: they take whatever value holds it."""
    slow = state.copy()
    std = np.sqrt(np.diagonal(motion.velocity_covariance, axis1=1, axis2=2))
    nu = motion.velocity
    slow[:, cart.velocity_slice] = np.sign(nu) * np.maximum(np.abs(nu) - STILL * std, 0.0)
    forces = cart.basis_b.T @ cart.stiction(slow, parameters, motion.time)
    total = np.tensordot(weights.linear, forces, 1)
    return np.asarray(total @ total.T)
