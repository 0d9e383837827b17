"""Parameters of a cart without the bias that noise of the motion makes (errors in variables), and how sure they are.

Noise in what is regressed on adds to the squares of the rows, and pulls parameters towards zero. What it adds is drawn:
the motion is worked out once more with the noise of its sensors added, and the squares of what that changes are taken
off (Fuller, Measurement Error Models, 1987). Combinations of parameters of which it makes most of the squares are told
by nothing but the first guess, such as inertia beside the yaw drag of a cart that hardly turns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import eigh

from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel

from ..discrepancy.search.model import Model
from ..parameter_report import IDENTIFIABLE_STD_RATIO
from ..weak_form.balances import Balances
from ..weak_form.coordinates import bounds, coordinates, jacobian, with_coordinates
from ..weak_form.linearized import Linearized

MAX_CORRECTED_ROUNDS, CORRECTED_FIT_SIGMAS = 12, 0.02
"""Most rounds in which rows are made linear; standard deviations by which the last moves a coordinate at most."""
MAX_NOISE_FRACTION = 0.5
"""Largest share of noise in the squares of a combination: one with more tells less than it hides."""
MIN_FIT_VARIANCE = 1e-300
"""Keeps fits of numbers beyond all reason finite."""
MIN_NOISE_DRAW_ROWS, MAX_NOISE_DRAWS = 400, 4
"""So many rows of noise tell its squares to a tenth; from shorter logs it is drawn several times."""


@dataclass(frozen=True, eq=False)
class CorrectedFit:
    """`covariance` (q, q) is of the coordinates that are free, then of what is unknown beside them, which go
    `with_mass` (q,) as its logarithm grows; `at_bound` (p,) are parameters that stand at one. It is settled if
    the last round moved it by less than its deviations."""

    model: Model
    covariance: Array
    with_mass: Array
    at_bound: np.ndarray
    is_settled: bool = True

    @property
    def free(self) -> np.ndarray:
        return np.flatnonzero(self.model.prior.free)

    @property
    def deviations(self) -> Array:
        """Standard deviations (f,) of the coordinates that are free."""
        return _deviations(self.covariance, len(self.free))

    def beside_mass(self, cart: CartModel) -> Array:
        """How far its free coordinates (f,) are from those of a cart, were the mass that one's."""
        off = (coordinates(self.model.cart) - coordinates(cart))[self.free]
        return np.asarray(off - self.with_mass[: len(off)] * off[0] if self.model.prior.free[0] else off)

    def between(self, bracket: float) -> CorrectedFit:
        """The fit with the mass in the middle of a bracket (a share of it) that a band leaves open beyond what
        scatters. All else goes along with the mass."""
        if not self.model.prior.free[0] or bracket**2 <= self.covariance[0, 0]:
            return self
        bracket = float(np.sqrt(bracket**2 - self.covariance[0, 0]))
        mass = self.with_mass
        z = coordinates(self.model.cart)
        z[self.free] += mass[: len(self.free)] * np.log1p(bracket)
        cart = with_coordinates(self.model.cart, np.clip(z, *bounds(self.model.cart)))
        covariance = self.covariance + bracket**2 * np.outer(mass, mass)
        return replace(self, model=replace(self.model, cart=cart), covariance=np.asarray(covariance))

    def physical(self) -> tuple[Array, Array]:
        """Mass, CoM, inertia and the effects' values, and their standard deviations (p,); of what is not estimated, as
        it was believed."""
        cart, std = self.model.cart, self.model.prior.std.copy()
        std[self.free] = self.deviations
        body, scale = cart.inertia, np.ones(len(std))
        scale[[0, 3]] = body.mass, body.about_com
        return np.array([body.mass, *body.com, body.about_com, *cart.parameters[N_PHI:]]), std * scale

    def taught(self, first: Array) -> np.ndarray:
        """Which (p,) are known much better than they were believed at first, with standard deviations (p,)."""
        values, std = self.physical()
        shrunk = np.zeros(len(std), dtype=bool)
        shrunk[self.free] = self.deviations < IDENTIFIABLE_STD_RATIO * self.model.prior.std[self.free]
        return np.asarray(shrunk & (std < IDENTIFIABLE_STD_RATIO * first) & ~self.at_bound & np.isfinite(values))

    @property
    def parameter_covariance(self) -> Array:
        """(p, p), of `(phi | effects' values)`."""
        by = jacobian(self.model.cart)[:, self.free]
        return np.asarray(by @ self.covariance[: len(self.free), : len(self.free)] @ by.T)


def corrected(model: Model) -> CorrectedFit:
    """The corrected fit, from a model that is fitted already."""
    model = replace(model, logs=tuple(balances.beside(None) for balances in model.logs))
    generator = np.random.default_rng(0)
    draws = int(np.clip(MIN_NOISE_DRAW_ROWS // len(model.rows), 1, MAX_NOISE_DRAWS))
    noisy = [tuple(b.with_more_noise(model.cart, generator) for b in model.logs) for _ in range(draws)]
    before, own = 0.0, np.flatnonzero(model.prior.free)
    for _ in range(MAX_CORRECTED_ROUNDS):
        equations = _Equations.of(model, noisy)
        found = equations.told().most_likely()
        moved = np.abs(coordinates(found.cart) - coordinates(model.cart))[own] / _deviations(found.covariance, len(own))
        model = replace(model, cart=found.resized())
        most = float((moved * ~found.at_bound[own]).max(initial=0.0))
        if most * min(most / before if before else 1.0, 1.0) < CORRECTED_FIT_SIGMAS:
            break
        before = most
    covariance = found.covariance
    with_mass = covariance[0] / covariance[0, 0]
    return CorrectedFit(model, equations.scatter(covariance), with_mass, found.at_bound, most < 1.0)


@dataclass(frozen=True, eq=False)
class _Equations:
    """At a model's cart: sums of products (b, q + 1, q + 1) of its rows by block, and of the noise in them."""

    model: Model
    sums: Array
    noise: Array

    @classmethod
    def of(cls, model: Model, noisy: Sequence[tuple[Balances, ...]]) -> _Equations:
        weight = model.score.scale**-2.0
        sums = np.tensordot(weight, model.sums, (0, 0))
        noise = np.zeros_like(sums)
        for logs in noisy:
            drawn = replace(model, logs=logs).rows - model.rows
            noise += np.tensordot(weight, model.folds.sums(drawn), (0, 0)) / len(noisy)
        here, free = np.eye(sums.shape[-1]), len(model.moved)
        here[:free, -1] = -model.moved  # rows have what is left at the prior's mean
        return cls(model, here.T @ sums @ here, here.T @ noise @ here)

    @cached_property
    def _onto_told(self) -> Array:
        """Projection (q, q) on combinations of unknowns that rows tell."""
        whole, noise = (each.sum(axis=0)[:-1, :-1] for each in (self.sums, self.noise))
        share, basis = eigh(noise, whole + np.diag(self.model.prior_std**-2.0))
        return np.asarray((basis * (share < MAX_NOISE_FRACTION)) @ np.linalg.inv(basis))

    def told(self) -> Linearized:
        """What rows tell, without what noise adds."""
        clean, onto, model = (self.sums - self.noise).sum(axis=0), self._onto_told, self.model
        information, pull = onto.T @ clean[:-1, :-1] @ onto, onto.T @ clean[:-1, -1]
        return Linearized(model.cart, model.prior, information, pull, model.prior_std[len(model.moved) :])

    def scatter(self, covariance: Array) -> Array:
        """The covariance, no smaller than what runs scatter (a sandwich estimator, White 1980, with clusters)."""
        q = len(covariance)
        pulls = (self.sums - self.noise)[:, :-1, -1] @ self._onto_told
        groups = _runs(self.model)
        clusters = np.array([pulls[groups == group].sum(axis=0) for group in np.unique(groups)])
        count = len(clusters)
        seen = covariance @ (clusters.T @ clusters) @ covariance * count / max(count - 1, 1)
        stretch = np.maximum(_deviations(seen, q) / _deviations(covariance, q), 1.0)
        return np.asarray(covariance * np.outer(stretch, stretch))


def _deviations(covariance: Array, count: int) -> Array:
    """Standard deviations of the first few (count,); numbers beyond all reason leave rounding alone."""
    return np.asarray(np.sqrt(np.maximum(np.diagonal(covariance)[:count], MIN_FIT_VARIANCE)))


def _runs(model: Model) -> np.ndarray:
    """For each block of the rows, a number for its stretch and its direction: what a model lacks forwards and backwards
    is not one error."""
    forward = [balances.integrated(balances.motion.velocity[:, 0]) for balances in model.logs]
    total = np.bincount(model.folds.block, np.concatenate(forward), len(model.folds.stretches))
    return np.asarray(2 * model.folds.stretches + (total > 0))
