"""Parameters of a cart without the bias that noise of the motion makes (errors in variables), and how sure they are.

Noise in what is regressed on adds to the squares of the rows, and pulls parameters towards zero. What it adds is drawn:
the motion is worked out once more with the noise of its sensors added, and the squares of what that changes are taken
off (Fuller, Measurement Error Models, 1987). Combinations of parameters of which it makes most of the squares are told
by nothing but the first guess, such as inertia beside the yaw drag of a cart that hardly turns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh

from cartgrasp.effects import ConstraintEffect
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel

from ..discrepancy.search.model import Model
from ..weak_form.balances import Balances
from ..weak_form.fit import coordinates, jacobian, with_coordinates

ROUNDS, SETTLED = 12, 0.02
"""Steps, and standard deviations by which the last moves a parameter at most."""
MOST_STEP = 1.0
"""Largest change of a logarithm in one step."""
MOST_NOISE = 0.5
"""Largest share of noise in the squares of a combination: one with more tells less than it hides."""
LEAST_VARIANCE = 1e-300
"""Keeps fits of numbers beyond all reason finite."""
DRAWN_ROWS, MOST_DRAWS = 400, 4
"""So many rows of noise tell its squares to a tenth; from shorter logs it is drawn several times."""
TAUGHT = 0.25
"""Share of the first guess's standard deviation below which a parameter counts as taught."""


@dataclass(frozen=True, eq=False)
class CorrectedFit:
    """`covariance` (q, q) is of the coordinates that are free, then of what is unknown beside them, which go
    `with_mass` (q,) as its logarithm grows; `at_bound` (p,) are
    parameters that stand at one."""

    model: Model
    covariance: Array
    with_mass: Array
    at_bound: np.ndarray

    @property
    def free(self) -> np.ndarray:
        return np.flatnonzero(self.model.prior.free)

    def between(self, bracket: float) -> CorrectedFit:
        """The fit with the mass in the middle of a bracket (a share of it) that a band leaves open beyond what
        scatters. All else goes along with the mass."""
        if not self.model.prior.free[0] or bracket**2 <= self.covariance[0, 0]:
            return self
        bracket = float(np.sqrt(bracket**2 - self.covariance[0, 0]))
        mass = self.with_mass
        z = coordinates(self.model.cart)
        z[self.free] += mass[: len(self.free)] * np.log1p(bracket)
        covariance = self.covariance + bracket**2 * np.outer(mass, mass)
        return replace(
            self, model=replace(self.model, cart=_bounded(self.model.cart, z)[0]), covariance=np.asarray(covariance)
        )

    def physical(self) -> tuple[Array, Array]:
        """Mass, CoM, inertia and the effects' values, and their standard deviations (p,); of what is not estimated, as
        it was believed."""
        cart, std = self.model.cart, self.model.prior.std.copy()
        std[self.free] = _deviations(self.covariance, len(self.free))
        body, scale = cart.inertia, np.ones(len(std))
        scale[[0, 3]] = body.mass, body.about_com
        return np.array([body.mass, *body.com, body.about_com, *cart.parameters[N_PHI:]]), std * scale

    def taught(self, first: Array) -> np.ndarray:
        """Which (p,) are known much better than they were believed at first, with standard deviations (p,)."""
        values, std = self.physical()
        prior = self.model.prior
        own = np.full(len(std), np.inf)
        own[self.free] = _deviations(self.covariance, len(self.free))
        shrunk = own < TAUGHT * prior.std
        return np.asarray(prior.free & shrunk & (std < TAUGHT * first) & ~self.at_bound & np.isfinite(values))

    @property
    def parameter_covariance(self) -> Array:
        """(p, p), of `(phi | effects' values)`."""
        by = jacobian(self.model.cart)[:, self.free]
        return np.asarray(by @ self.covariance[: len(self.free), : len(self.free)] @ by.T)


def corrected(model: Model) -> CorrectedFit:
    """The corrected fit, from a model that is fitted already."""
    model = replace(model, logs=tuple(balances.beside(None) for balances in model.logs))
    generator = np.random.default_rng(0)
    draws = int(np.clip(DRAWN_ROWS // len(model.rows), 1, MOST_DRAWS))
    noisy = [tuple(b.with_more_noise(model.cart, generator) for b in model.logs) for _ in range(draws)]
    before = 0.0
    for _ in range(ROUNDS):
        equations = _Equations.of(model, noisy)
        step, covariance = equations.step()
        model, at_bound = _stepped(model, step)
        own = np.flatnonzero(model.prior.free)
        moved = np.abs(step[: len(own)]) / _deviations(covariance, len(own)) * ~at_bound[own]
        most = float(moved.max(initial=0.0))
        if most * min(most / before if before else 1.0, 1.0) < SETTLED:
            break
        before = most
    return CorrectedFit(model, equations.scatter(covariance), covariance[0] / covariance[0, 0], at_bound)


@dataclass(frozen=True, eq=False)
class _Equations:
    """At a model's cart: sums of products (b, q + 1, q + 1) of its rows by block, less what noise adds, and of that
    noise; the first guess's pull (q,) and information (q, q)."""

    model: Model
    sums: Array
    noise: Array
    prior_pull: Array
    prior_information: Array

    @classmethod
    def of(cls, model: Model, noisy: Sequence[tuple[Balances, ...]]) -> _Equations:
        weight = model.score.scale**-2.0
        sums = np.tensordot(weight, model.sums, (0, 0))
        noise = np.zeros_like(sums)
        for logs in noisy:
            drawn = replace(model, logs=logs).rows - model.rows
            noise += np.tensordot(weight, model.folds.sums(drawn), (0, 0)) / len(noisy)
        information, here, free = model.prior_std**-2.0, np.eye(sums.shape[-1]), len(model.moved)
        here[:free, -1] = -model.moved  # rows have what is left at the prior's mean
        sums, noise = here.T @ sums @ here, here.T @ noise @ here
        pull = np.zeros(len(information))
        pull[:free] = -model.moved * information[:free]
        return cls(model, sums, noise, pull, np.diag(information))

    def _told(self) -> tuple[Array, Array]:
        """Combinations of unknowns (q, r) that rows tell, and all (q, q), in which information is one."""
        q = len(self.prior_pull)
        whole, noise = (each.sum(axis=0)[:q, :q] for each in (self.sums, self.noise))
        share, basis = eigh(noise, whole + self.prior_information)
        return np.where(share < MOST_NOISE, 1.0, 0.0), np.asarray(basis)

    def step(self) -> tuple[Array, Array]:
        """The step to take (q,), and its covariance (q, q)."""
        q = len(self.prior_pull)
        told, basis = self._told()
        clean = (self.sums - self.noise).sum(axis=0)
        prior = basis.T @ self.prior_information @ basis
        information = np.outer(told, told) * (basis.T @ clean[:q, :q] @ basis) + prior
        pull = told * (basis.T @ clean[:q, q]) + basis.T @ self.prior_pull
        covariance = basis @ np.linalg.inv(information) @ basis.T
        return np.asarray(basis @ np.linalg.solve(information, pull)), np.asarray(covariance)

    def scatter(self, covariance: Array) -> Array:
        """The covariance, no smaller than what runs scatter (a sandwich estimator, White 1980, with clusters)."""
        q = len(self.prior_pull)
        told, basis = self._told()
        clean = self.sums - self.noise
        pulls = clean[:, :q, q] @ (basis * told) @ np.linalg.inv(basis)
        groups = _runs(self.model)
        clusters = np.array([pulls[groups == group].sum(axis=0) for group in np.unique(groups)])
        count = len(clusters)
        seen = covariance @ (clusters.T @ clusters) @ covariance * count / max(count - 1, 1)
        stretch = np.maximum(_deviations(seen, q) / _deviations(covariance, q), 1.0)
        return np.asarray(covariance * np.outer(stretch, stretch))


def _deviations(covariance: Array, count: int) -> Array:
    """Standard deviations of the first few (count,); numbers beyond all reason leave rounding alone."""
    return np.asarray(np.sqrt(np.maximum(np.diagonal(covariance)[:count], LEAST_VARIANCE)))


def _runs(model: Model) -> np.ndarray:
    """For each block of the rows, a number for its stretch and its direction: what a model lacks forwards and backwards
    is not one error."""
    forward = [balances.integrated(balances.motion.velocity[:, 0]) for balances in model.logs]
    total = np.bincount(model.folds.block, np.concatenate(forward), len(model.folds.stretches))
    return np.asarray(2 * model.folds.stretches + (total > 0))


def _stepped(model: Model, step: Array) -> tuple[Model, np.ndarray]:
    free = np.flatnonzero(model.prior.free)
    z = coordinates(model.cart)
    z[free] += step[: len(free)]
    first = coordinates(model.cart)
    for i in (0, 3):
        z[i] = first[i] + np.clip(z[i] - first[i], -MOST_STEP, MOST_STEP)
    cart, at_bound = _bounded(model.cart, z)
    sizes = step[len(free) : len(free) + len(cart.constraint_effects)]
    scaled = {e.key: e.scaled(1.0 + float(s)) for e, s in zip(cart.constraint_effects, sizes, strict=True)}
    effects = tuple(scaled.get(e.key, e) if isinstance(e, ConstraintEffect) else e for e in cart.effects)
    return replace(model, cart=replace(cart, effects=effects)), at_bound


def _bounded(cart: CartModel, z: Array) -> tuple[CartModel, np.ndarray]:
    """The cart at coordinates (p,) within bounds, and which (p,) met one."""
    lower = np.concatenate([np.full(N_PHI, -np.inf), *([p.lower for p in e.parameters] for e in cart.effects)])
    upper = np.concatenate([np.full(N_PHI, np.inf), *([p.upper for p in e.parameters] for e in cart.effects)])
    return with_coordinates(cart, np.clip(z, lower, upper)), (z <= lower) | (z >= upper)
