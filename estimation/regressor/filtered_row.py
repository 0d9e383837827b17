"""Rows of the filtered regression: both sides of the reduced dynamics through `F = rate / (s + rate)`, once a block.

The wrench is `Mr nu' + g(nu)`, and Mr is constant in the body frame (physics 4), so that no velocity is differentiated:
`F[Mr nu'] = Mr rate (nu - F[nu])`. Successive values of a filter share their noise. What is new after a block of T,
`F_k - exp(-rate T) F_(k-1)`, is an integral over the block alone,

    B[x] = ∫ rate exp(-rate (t_k - s)) x(s) ds,    B[nu'] = rate (nu_k - exp(-rate T) nu_(k-1) - B[nu]),

whose wrench noise no other block has; what is wrong with nu_k stands in two neighbours with unlike signs. And since
what is wrong with nu at one moment is fast, while poses tell where it went in the mean, a row is the mean over blocks
that begin a little later and later: nu_k is then a mean, too, and neighbours share some of the wrench's noise.

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
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel

from ..gaussian import Gaussian
from ..noise import FilterNoise
from ..wrench_sensing import SensedWrench
from .motion_tracker import Stretch

RATE = 2.0
"""1/s, of the filter."""
STILL = 3.0
"""Standard deviations of nu within which a cart may stand still, or be as fast as asked."""
FLOOR_SHARE = 0.002
"""Of the wrench: what a model leaves out."""
REMEMBERED_SHARE = 1.0
"""Of what effects with a memory do in a row: what a model leaves out of it. Half of it goes wrong, where a caster
swings a little sooner or later, and stays so for some four rows."""
STANDS_OUT = 2.0
"""Standard deviations of B[nu'], and of nu, that teach nothing."""
NOISE_SHARE = 0.9
"""Of the variance of B[nu']: what is noise of sensors, and not motion that was smoothed away; down to a half where
there are poor poses alone."""


@dataclass(frozen=True)
class Weights:
    """Of the block's integral: for a function that is linear between instants (n,), and for one held (n - 1,);
    `of_white` is the variance, 1/s, of what it makes of white noise."""

    linear: Array
    held: Array
    fade: float
    width: int
    of_white: float

    @classmethod
    def of(cls, time: Array, width: int = 1) -> Weights:
        """The mean over blocks of n - width steps that begin at each of the first `width` instants."""
        n = len(time) - width
        h, faded = np.diff(time), np.exp(-RATE * (time[n:] - time[-1]))
        sums, i = np.append(0.0, np.cumsum(faded)), np.arange(len(time) - 1)
        share = (sums[np.minimum(i + 1, width)] - sums[np.maximum(i - n + 1, 0)]) / width
        gain, left = -np.expm1(-RATE * h), share * np.exp(RATE * (time[1:] - time[-1]))
        second = 1.0 - gain / (RATE * h)
        linear = np.append(left * (gain - second), 0.0)
        linear[1:] += left * second
        held, fade = left * gain, float(np.exp(-RATE * (time[n:] - time[:width])).mean())
        return cls(linear, held, fade, width, float((held**2 / h).sum()))

    @property
    def of_motion(self) -> Array:
        """Weights (3, n) of means over the blocks' first and last instants, and of what is new between them."""
        found = np.zeros((3, len(self.linear)))
        found[0, : self.width] = found[1, -self.width :] = 1.0 / self.width
        found[2] = found[1] - self.fade * found[0] - self.linear
        return found

    @property
    def shared(self) -> float:
        """Of a row's noise that is white and not of the motion, the share that the next row has, too."""
        n = len(self.linear) - self.width
        return float(self.held[n:] @ self.held[: self.width - 1] / (self.held @ self.held))


class Recorded(NamedTuple):
    """The sensed reduced wrench of a moment, worked out at `parameters` (p,); `time` is its sample's, which may be some
    moments old."""

    time: float
    sensed: SensedWrench
    parameters: Array


@dataclass(frozen=True)
class FilteredRow:
    """`residual = slopes @ (change of theta | lateness) + ends @ (e_k - fade e_(k-1)) + noise`, with e what is wrong
    with the mean nu at the ends, of covariance `before` and `after`. `feigned` (p + 1,) is what noise in the slopes
    adds to the mean of `slopesᵀ W residual`, `shared` (f, f) the part of the noise that each neighbour has, too."""

    residual: Array
    slopes: Array
    ends: Array
    fade: float
    noise: Array
    before: Array
    after: Array
    feigned: Array
    shared: Array


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


def is_slower(motion: Stretch, cart: CartModel, speed: float) -> bool:
    """Whether {b}'s origin is seen to be, at some moment of the block (m/s)."""
    basis = cart.basis_b[:2]
    found = np.linalg.norm(motion.velocity @ basis.T, axis=1)
    std = np.sqrt(np.einsum("ia,nab,ib->n", basis, motion.velocity_covariance, basis))
    return bool((found + STILL * std < speed).any())


@dataclass(frozen=True)
class Block:
    """What a row is worked out from: n smoothed moments with sums by `weights.of_motion`, memory (n, k), and wrenches
    (n - 1), each held to the next moment."""

    weights: Weights
    motion: Stretch
    memory: Array
    recorded: Sequence[Recorded]

    @property
    def states(self) -> Array:
        """(n, s)."""
        return np.hstack([self.motion.pose, self.motion.velocity, self.memory])


def filtered_row(cart: CartModel, known: Gaussian, block: Block, noise: FilterNoise) -> FilteredRow:
    """Of a block around the parameters (p,) that are known by now."""
    parameters = known.mean
    weights, motion, recorded, state = block.weights, block.motion, block.recorded, block.states
    rest = cart.inverse(state, np.zeros_like(motion.velocity), parameters, motion.time)
    f = motion.velocity.shape[1]
    before, after, of_rise = motion.of_sums
    rise = Rise.of(RATE * weights.of_motion[2] @ motion.velocity, RATE**2 * of_rise)
    asked = np.vstack([np.zeros(f), rise.part, np.eye(f)])
    moved = cart.inverse(np.tile(state[-1], (f + 2, 1)), asked, parameters, motion.time[-1])
    mass, by_acceleration = moved.by_acceleration[0], moved.by_parameters[2:] - moved.by_parameters[0]
    expected = weights.linear @ rest.wrench + mass @ rise.whole
    standing_out = cart.inverse(_standing_out(cart, block), np.zeros_like(motion.velocity), parameters, motion.time)
    by_parameters = np.tensordot(weights.linear, standing_out.by_parameters, 1)
    by_parameters = by_parameters + moved.by_parameters[1] - moved.by_parameters[0]
    step = float(np.diff(motion.time).mean())
    late = step * RATE * weights.of_motion[2] @ (rest.wrench + motion.acceleration @ mass.T)
    measured, measured_by = _measured(parameters, recorded, weights)
    white = _noise(cart, recorded, weights, noise)
    own = white + _floor(recorded, weights) + _stuck(cart, known, block) + _remembered(cart, parameters, by_parameters)
    return FilteredRow(
        residual=measured - expected,
        slopes=np.column_stack([by_parameters - measured_by, late]),
        ends=-RATE * mass,
        fade=weights.fade,
        noise=own,
        before=before,
        after=after,
        feigned=np.append(rise.feigned(by_acceleration, mass, own), 0.0),
        shared=weights.shared * white,
    )


def curvature_noise(cart: CartModel, parameters: Array, block: Block, spread: Array) -> Array:
    """Covariance (f, f) of what a row that is linear in the parameters leaves out, where they are known to within
    `spread @ z`, (p, q), with standard normal z: `tr(T T) / 2` of `zᵀ T z / 2`. Load times friction is not linear."""
    motion = block.motion
    k = len(motion.time) // 2
    state = block.states[k]
    around = parameters + np.vstack([np.zeros(len(parameters)), spread.T])
    rows = np.tile(state, (len(around), 1))
    by = cart.inverse(rows, np.tile(motion.acceleration[k], (len(around), 1)), around, motion.time[k]).by_parameters
    twist = (by[1:] - by[0]) @ spread
    gain = block.weights.linear.sum()
    return np.asarray(gain**2 / 2 * np.einsum("qfr,qgr->fg", twist, twist))


def _standing_out(cart: CartModel, block: Block) -> Array:
    """The states (n, s) with the part of nu that stands out of its noise: in slopes, noise would count as motion."""
    states, motion = block.states, block.motion
    variance = np.diagonal(motion.velocity_covariance, axis1=1, axis2=2)
    nu = states[:, cart.velocity_slice]
    square = STANDS_OUT**2 * variance / np.maximum(nu**2, 1e-300)
    states[:, cart.velocity_slice] = np.maximum(1.0 - square, 0.0) * nu
    return states


def _measured(parameters: Array, recorded: Sequence[Recorded], weights: Weights) -> tuple[Array, Array]:
    """B of the wrenches (f,), and its partials (f, p)."""
    by = np.array([one.sensed.by_parameters for one in recorded])
    change = np.array([parameters - one.parameters for one in recorded])
    values = np.array([one.sensed.value for one in recorded]) + np.einsum("nfp,np->nf", by, change)
    return weights.held @ values, np.tensordot(weights.held, by, 1)


def _noise(cart: CartModel, recorded: Sequence[Recorded], weights: Weights, noise: FilterNoise) -> Array:
    """Of sensors, a sample that stands for several moments counted whole; and of disturbances."""
    f = cart.constraints.n_free
    total = np.zeros((f, f))
    _, sample = np.unique([one.time for one in recorded], return_inverse=True)
    shares = np.bincount(sample, weights.held)
    for share, i in zip(shares, np.unique(sample, return_index=True)[1], strict=True):
        total += share**2 * recorded[i].sensed.covariance
    disturbance = cart.basis_b.T @ np.diag([1.0, 1.0, noise.lever]) * noise.disturbance
    return np.asarray(total + weights.of_white * disturbance @ disturbance.T)


def _floor(recorded: Sequence[Recorded], weights: Weights) -> Array:
    """Of what a model leaves out."""
    size = weights.held @ np.abs([one.sensed.value for one in recorded])
    return np.asarray(np.diag(FLOOR_SHARE * size) ** 2 + 1e-10 * np.eye(len(size)))


def _stuck(cart: CartModel, known: Gaussian, block: Block) -> Array:
    """Of Coulomb forces where the cart may stand still, for all that nu tells: they take whatever value holds it. They
    may be as large as they are known to be: counted as they are believed, a swivel torque would be learned away while
    casters just trail."""
    slow, motion = block.states, block.motion
    std = np.sqrt(np.diagonal(motion.velocity_covariance, axis1=1, axis2=2))
    nu = motion.velocity
    slow[:, cart.velocity_slice] = np.sign(nu) * np.maximum(np.abs(nu) - STILL * std, 0.0)
    most = known.mean.copy()
    most[N_PHI:] += known.std[N_PHI:]
    forces = cart.basis_b.T @ cart.stiction(slow, most, motion.time)
    total = np.tensordot(block.weights.linear, forces, 1)
    return np.asarray(total @ total.T)


def _remembered(cart: CartModel, parameters: Array, by_parameters: Array) -> Array:
    """Of effects with a memory, from the row's partials (f, p)."""
    asked = np.zeros(len(by_parameters))
    for effect, where, memory in cart.force_effects:
        if memory.stop > memory.start:
            estimated = [
                i for i, p in zip(range(where.start, where.stop), effect.parameters, strict=True) if p.estimated
            ]
            asked += by_parameters[:, estimated] @ parameters[estimated]
    return np.asarray(REMEMBERED_SHARE**2 * np.outer(asked, asked))
