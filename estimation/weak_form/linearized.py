"""The most likely cart of whitened rows, which are made linear in its parameters round by round: in mass, first moments
and inertia about {b}, and those of effects.

Coordinates of physical carts are not linear in them: where the inertia about {b} is known better than the CoM, carts
that are as likely lie on a bend, across which Gauss-Newton steps to and fro. So the least of the quadratic form over
all physical carts is found to the end, which asks nothing more of a log.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from .balances import Balances
from .coordinates import ParameterPrior, bounds, coordinates, jacobian, parameters_at, slopes_at, with_coordinates
from .whitening import Whitening

MAX_LINEARISATIONS, CONVERGENCE_SIGMAS = 12, 0.05
"""Most rounds in which rows are made linear; standard deviations by which the last moves a coordinate at most."""
INFORMATION_ROUNDING = 1e-9
"""What rounding leaves: of information, as a share of the prior's, and of a distance, in its standard deviations."""


@dataclass(frozen=True, eq=False)
class MostLikely:
    """A cart, what is unknown beside it (q,), the covariance (f + q, f + q) of its free coordinates and of that as if
    there were no bounds, and which (p,) coordinates stand at one."""

    cart: CartModel
    beside: Array
    covariance: Array
    at_bound: np.ndarray

    def resized(self) -> CartModel:
        """The cart with constraint effects of the sizes that come first in what is beside it."""
        sizes = zip(self.cart.constraint_effects, self.beside.tolist(), strict=False)
        resized = {effect.key: effect.scaled(1.0 + size) for effect, size in sizes}
        return replace(self.cart, effects=tuple(resized.get(effect.key, effect) for effect in self.cart.effects))


@dataclass(frozen=True, eq=False)
class Linearized:
    """Rows at a cart: information (f + q, f + q) and pull (f + q,) of its free coordinates, then of what is unknown
    beside them, which has standard deviations (q,)."""

    cart: CartModel
    prior: ParameterPrior
    information: Array
    pull: Array
    beside_std: Array

    def most_likely(self) -> MostLikely:
        """The most likely cart, from this one on."""
        free, prior = self.free, self.prior
        lower, upper = (bound[free] for bound in bounds(self.cart))
        mean, std = prior.mean[free], prior.std[free]
        root, aim = self._roots()

        def residual(z: Array) -> Array:
            return np.append(root @ self._away(z) - aim, (z - mean) / std)

        def slopes(z: Array) -> Array:
            return np.vstack([root @ self._slopes(z), np.diag(1.0 / std)])

        start = np.clip(coordinates(self.cart)[free], lower, upper)
        first = slopes(start)
        scale = np.sqrt(np.diagonal(np.linalg.inv(first.T @ first)))
        with np.errstate(over="ignore", invalid="ignore"):  # of steps that are too long, and are tried shorter
            found = least_squares(residual, start, slopes, (lower, upper), "dogbox", x_scale=scale)
        z = found.x
        for bound in (lower, upper):  # a step to a bound ends beside it by rounding
            z = np.where(np.abs(z - bound) < INFORMATION_ROUNDING * std, bound, z)
        at_bound = np.zeros(len(prior.free), dtype=bool)
        at_bound[free] = (z == lower) | (z == upper)
        beside = self._beside @ (self.pull[len(free) :] - self._across.T @ self._away(z))
        every_std = np.append(std, self.beside_std)
        by = np.eye(len(every_std))
        by[: len(z), : len(z)] = self._slopes(z)
        covariance = np.asarray(np.linalg.inv(by.T @ self.information @ by + np.diag(every_std**-2.0)), dtype=float)
        return MostLikely(with_coordinates(self.cart, self._at(z)), beside, covariance, at_bound)

    @cached_property
    def free(self) -> np.ndarray:
        """Numbers (f,) of the coordinates that are estimated."""
        return np.flatnonzero(self.prior.free)

    def _at(self, z: Array) -> Array:
        """All coordinates (p,), of which (f,) are free."""
        whole = coordinates(self.cart)
        whole[self.free] = z
        return whole

    def _away(self, z: Array) -> Array:
        """How far (f,) free coordinates would have gone where rows are, were they linear in them."""
        return np.asarray(self._to_coordinates @ (parameters_at(self._at(z)) - self.cart.parameters))

    def _slopes(self, z: Array) -> Array:
        """Partials (f, f) of `_away`."""
        return np.asarray(self._to_coordinates @ slopes_at(self._at(z))[:, self.free])

    @cached_property
    def _to_coordinates(self) -> Array:
        return np.asarray(np.linalg.inv(jacobian(self.cart))[self.free])

    @cached_property
    def _across(self) -> Array:
        return self.information[: len(self.free), len(self.free) :]

    @cached_property
    def _beside(self) -> Array:
        """Covariance (q, q) of what is unknown beside the coordinates, were these known."""
        f = len(self.free)
        return np.asarray(np.linalg.inv(self.information[f:, f:] + np.diag(self.beside_std**-2.0)))

    def _roots(self) -> tuple[Array, Array]:
        """What rows tell, whatever is beside: a root (r, f) of the information, and where it leads (r,)."""
        f, std = len(self.free), self.prior.std[self.free]
        information = self.information[:f, :f] - self._across @ self._beside @ self._across.T
        pull = self.pull[:f] - self._across @ self._beside @ self.pull[f:]
        share, basis = np.linalg.eigh(std[:, None] * information * std)
        told = share > INFORMATION_ROUNDING
        root = np.sqrt(share[told])[:, None] * basis[:, told].T
        return root / std, basis[:, told].T @ (std * pull) / np.sqrt(share[told])


@dataclass(frozen=True, eq=False)
class Nuisance:
    """What is unknown beside the parameters: of each log raw columns (k, c, q), and their standard deviations (q,)."""

    columns: tuple[Array, ...]
    std: Array


def fit(
    logs: Sequence[tuple[Balances, Whitening]], cart: CartModel, prior: ParameterPrior, nuisance: Nuisance
) -> MostLikely:
    """The most likely cart, from this one on."""
    beside = [whiten(own) for (_, whiten), own in zip(logs, nuisance.columns, strict=True)]
    for _ in range(MAX_LINEARISATIONS):
        information, pull = normal(logs, cart, beside, prior.free)
        found = Linearized(cart, prior, information, pull, nuisance.std).most_likely()
        moved = (coordinates(found.cart) - coordinates(cart))[prior.free]
        cart = found.cart
        if (np.abs(moved) < CONVERGENCE_SIGMAS * np.sqrt(np.diagonal(found.covariance)[: len(moved)])).all():
            break
    return found


def normal(
    logs: Sequence[tuple[Balances, Whitening]], cart: CartModel, beside: Sequence[Array], free: np.ndarray
) -> tuple[Array, Array]:
    """Information (f + q, f + q) and pull (f + q,) of the coordinates that are free and of whitened columns beside
    them."""
    by = jacobian(cart)[:, free]
    size = by.shape[1] + beside[0].shape[2]
    information, pull = np.zeros((size, size)), np.zeros(size)
    for (balances, whiten), columns in zip(logs, beside, strict=True):
        left, slopes = balances.residual(cart)
        white = whiten(np.concatenate([slopes @ by, left[..., None]], axis=2))
        flat = np.concatenate([white[..., :-1], columns, white[..., -1:]], axis=2).reshape(-1, size + 1)
        joint = flat.T @ flat
        information += joint[:size, :size]
        pull += joint[:size, size]
    return information, pull
