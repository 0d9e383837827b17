"""Rows of the filtered regression: both sides of the reduced dynamics through `F = rate / (s + rate)`, once a block.

The wrench is `Mr nu' + g(nu)`, and Mr is constant in the body frame, so that no velocity is differentiated:
`F[Mr nu'] = Mr rate (nu - F[nu])`. Successive values of a filter share their noise. What is new after a block of T,
`F_k - exp(-rate T) F_(k-1)`, is an integral over the block alone,

    B[x] = ∫ rate exp(-rate (t_k - s)) x(s) ds,    B[nu'] = rate (nu_k - exp(-rate T) nu_(k-1) - B[nu]),

whose wrench noise no other block has; what is wrong with nu_k stands in two neighbours with unlike signs. And since
what is wrong with nu at one moment is fast, while poses tell where it went in the mean, a row is the mean over blocks
that begin a little later and later: nu_k is then a mean, too, and neighbours share some of the wrench's noise.

What noise in B[nu'] does, which is in a row's slopes and in its residual alike, is taken off where rows add up
(`kernels/slope_noise.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel

from ...gaussian import Gaussian
from ...noise import FilterNoise
from ...standstill import HALF_TRACK, STANDSTILL_SPEED
from ..kernels import row_algebra as kernels
from ..kernels.row_algebra import Asked, FilteredRow, Found, Smoothed, UnmodelledNoise, Weights
from ..kernels.row_parts import STANDSTILL_SIGMAS


@dataclass(frozen=True)
class Block:
    """What a row is worked out from: n smoothed moments, and wrenches, each held to the next moment, as rows (n - 1) of
    `kernels/measured_wrench.py`, which were recorded `ahead` (s) of their moments."""

    weights: Weights
    moved: Smoothed
    wrenches: Array
    ahead: float = 0.0


def stands_still(moved: Smoothed, cart: CartModel) -> bool:
    """Whether the cart may, all the block long: it creeps at most, or nothing is seen to move."""
    twist = moved.velocity @ cart.basis_b.T
    creeps = np.hypot(twist[:, 0], twist[:, 1]) + HALF_TRACK * np.abs(twist[:, 2]) < STANDSTILL_SPEED
    is_unseen = moved.velocity**2 < STANDSTILL_SIGMAS**2 * np.diagonal(moved.covariance, axis1=1, axis2=2)
    return bool(creeps.all() or is_unseen.all())


def is_slower(moved: Smoothed, cart: CartModel, speed: float) -> bool:
    """Whether {b}'s origin is seen to be, at some moment of the block (m/s)."""
    basis = cart.basis_b[:2]
    found = np.linalg.norm(moved.velocity @ basis.T, axis=1)
    std = np.sqrt(np.einsum("ia,nab,ib->n", basis, moved.covariance, basis))
    return bool((found + STANDSTILL_SIGMAS * std < speed).any())


class AskedRow(NamedTuple):
    """The row of a block on its way, around the parameters (p,) `known` by then, to within `spread @ z`, (p, q): what
    inverse dynamics have answered so far for the moments at which they are `asked`."""

    block: Block
    known: Gaussian
    spread: Array
    rise: Array
    asked: Asked
    answers: tuple[tuple[Array, Array], ...] = ()

    @classmethod
    def of(cls, block: Block, known: Gaussian, spread: Array) -> AskedRow:
        return cls(block, known, spread, *kernels.begun(block.weights, block.moved, known.mean, spread))

    @property
    def _done(self) -> int:
        return sum(len(wrench) for wrench, _ in self.answers)

    @property
    def is_answered(self) -> bool:
        return self._done == len(self.asked.time)

    def go_on(self, cart: CartModel, count: int) -> AskedRow:
        """With so many moments more."""
        state, acceleration, parameters, time = (part[self._done : self._done + count] for part in self.asked)
        return self._replace(answers=(*self.answers, cart.inverse_by_parameters(state, acceleration, parameters, time)))

    def filtered(self, cart: CartModel, unmodelled: UnmodelledNoise) -> FilteredRow:
        """The filtered row, once all is answered.

        Coulomb forces that may hold a cart which stands still may be as large as they are known to be: counted as they
        are believed, a swivel torque would be learned away while casters just trail."""
        moved, theta, covariance = self.block.moved, self.known.mean, self.known.covariance
        slow, most = self.asked.state[: len(moved.time)].copy(), theta.copy()
        slow[:, cart.velocity_slice] = _slowest(moved)
        most[N_PHI:] += np.sqrt(np.maximum(np.diagonal(covariance)[N_PHI:], 0.0))
        stuck = np.ascontiguousarray(cart.basis_b.T @ cart.stiction(slow, most, moved.time))
        wrench, by_parameters = (np.concatenate(parts) for parts in zip(*self.answers, strict=True))
        given = self.block.wrenches, self.block.ahead, theta, self.spread
        found = Found(wrench, by_parameters, stuck)
        return kernels.row(self.block.weights, self.rise, found, moved, given, unmodelled)


def _slowest(moved: Smoothed) -> Array:
    """The slowest (n, f) that each nu may be."""
    std = np.sqrt(np.diagonal(moved.covariance, axis1=1, axis2=2))
    left = np.maximum(np.abs(moved.velocity) - STANDSTILL_SIGMAS * std, 0.0)
    return np.asarray(np.where(left > 0.0, np.copysign(left, moved.velocity), 0.0))


def one_disturbance(cart: CartModel, noise: FilterNoise) -> Array:
    """The density (f, f) of disturbances of 1 N·√s, whose moments are by the noise's lever."""
    root = cart.basis_b.T * [1.0, 1.0, noise.lever]
    return np.asarray(root @ root.T)
