"""The parameters inside the filter's state: which are free, in what coordinates, and how they are reported."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.inertia import phi_from_physical, physical_from_phi, physical_jacobian
from cartgrasp.model import N_PHI, CartModel
from cartgrasp.motion import ParameterEstimate

from .mobility import build_chart
from .prior import Prior, report_names, report_units

IDENTIFIABLE_SHARE = 0.25
LOAD_SHARE = 0.3
LEAST_MASS_SHARE, LEAST_INERTIA_SHARE = 0.1, 0.05
LARGEST_MASS_SHARE = 6.0
FARTHEST = 3.0
"""CoM and radius of gyration stay within this many of the prior's CoM standard deviations."""


class ParameterBlock:
    """Between the free coordinates (f,) that the filter carries and the model's parameters (p,)."""

    def __init__(self, cart: CartModel, prior: Prior) -> None:
        self.cart, self.prior = cart, prior
        self.free = prior.free(cart)
        self._chart = build_chart(cart.constraints)
        self._phi_is_free = bool(np.isin(0, self.free))
        self._full = cart.parameters.copy()
        self._full[:N_PHI] = self._chart.coordinates(cart.inertia.phi)
        self.first = self._full[self.free]
        self._prior_std = prior.deviations(cart)
        self._is_free = np.isin(np.arange(len(self._full)), self.free)
        self._names = tuple(zip(report_names(cart), report_units(cart), strict=True))
        self._reach = FARTHEST * prior.com
        self._lower, self._upper = self._bounds()

    @cached_property
    def first_covariance(self) -> Array:
        """Of the first guess, (f, f), in the filter's coordinates."""
        return self._to_coordinates(self.prior.covariance(self.cart), self.first)

    def theta(self, block: Array) -> Array:
        """The model's parameters (p,), with phi kept physical: m > 0, J m > |m d|² (physics 18)."""
        full = self._tamed(block)
        phi = self._chart.phi(full[:N_PHI])
        full[:N_PHI] = self._physical_phi(phi) if self._phi_is_free else phi
        return full

    def jacobian(self, block: Array) -> Array:
        """Partials (p, f) of `theta`."""
        full = self._tamed(block)
        partials = np.eye(len(full))
        partials[:N_PHI, :N_PHI] = self._chart.jacobian(full[:N_PHI])
        return partials[:, self.free]

    def _bounds(self) -> tuple[Array, Array]:
        """Of the free coordinates: what a cart like the first guess can have, and the effects' own bounds."""
        body = self.cart.inertia
        mass, J = body.mass, body.about_origin
        largest_J = max(4 * J, 2 * mass * self._reach**2)
        low, high = self._chart.bounds(
            LARGEST_MASS_SHARE * mass, LEAST_MASS_SHARE * mass, largest_J, LEAST_INERTIA_SHARE * body.about_com
        )
        ranges = [(p.lower, p.upper) for effect in self.cart.effects for p in effect.parameters]
        lower, upper = np.array([*zip(low, high, strict=True), *ranges])[self.free].T
        return lower, upper

    def within_bounds(self, block: Array) -> Array:
        """The block with every coordinate inside its bounds."""
        return np.clip(block, self._lower, self._upper)

    def physical(self, block: Array) -> Array:
        """The block itself, or with phi brought back to what a cart can have: m > 0, J m > |m d|² (physics 18)."""
        if not self._phi_is_free:
            return block
        full = self._full.copy()
        full[self.free] = self.within_bounds(block)
        tamed = self._chart.tamed(full[:N_PHI], self._reach)
        phi = self._chart.phi(tamed)
        physical = self._physical_phi(phi)
        if (tamed == full[:N_PHI]).all() and (physical == phi).all():
            return block
        full[:N_PHI] = self._chart.coordinates(physical)
        return np.asarray(full[self.free])

    def _tamed(self, block: Array) -> Array:
        """All coordinates (p,), with a mass that is positive and finite."""
        full = self._full.copy()
        full[self.free] = self.within_bounds(block)
        full[:N_PHI] = self._chart.tamed(full[:N_PHI], self._reach)
        return full

    def _physical_phi(self, phi: Array) -> Array:
        """phi itself, or with mass, CoM and inertia brought back to what a cart can have."""
        body, reach = self.cart.inertia, self._reach
        mass, com_x, com_y, about_com = physical_from_phi(phi)
        if not mass >= LEAST_MASS_SHARE * body.mass:
            mass, com_x, com_y = LEAST_MASS_SHARE * body.mass, *body.com
        least, most = LEAST_INERTIA_SHARE * body.about_com, max(4 * body.about_com, mass * reach**2)
        near_x, near_y = (np.clip(v, c - reach, c + reach) for v, c in zip((com_x, com_y), body.com, strict=True))
        inside = np.clip(about_com, least, most)
        if (mass, near_x, near_y, inside) == (phi[0], com_x, com_y, about_com):
            return phi
        return phi_from_physical(mass, near_x, near_y, inside)

    def load_covariance(self, block: Array) -> Array:
        """What a load change may add, (f, f): a point mass put on or taken off, `m (1, x, y, x² + y²)`, with m
        and (x, y) independent, centred on the first guess of the CoM."""
        theta = self.theta(block)
        x, y = self.cart.inertia.com
        mass, place = LOAD_SHARE * theta[0], self.prior.com
        shape = np.array([1.0, x, y, x**2 + y**2 + 2 * place**2])
        spread = np.diag([0.0, place**2, place**2, 4 * place**2 * (x**2 + y**2) + 4 * place**4])
        spread[3, 1] = spread[1, 3] = 2 * x * place**2
        spread[3, 2] = spread[2, 3] = 2 * y * place**2
        covariance = np.zeros((len(theta), len(theta)))
        covariance[:N_PHI, :N_PHI] = mass**2 * (np.outer(shape, shape) + spread)
        return self._to_coordinates(covariance, block)

    def report(self, block: Array, covariance: Array) -> dict[str, ParameterEstimate]:
        """The parameters by name, with standard deviations and whether this motion has taught them."""
        theta = self.theta(block)
        to_report = np.eye(len(theta))
        to_report[:N_PHI, :N_PHI] = physical_jacobian(theta[:N_PHI])
        root = to_report @ self.jacobian(block)
        std = np.sqrt(np.maximum(((root @ covariance) * root).sum(axis=1), 0.0))
        learned = self._is_free & (std < IDENTIFIABLE_SHARE * self._prior_std) & self._has_shrunk(covariance)
        theta[:N_PHI] = physical_from_phi(theta[:N_PHI])
        if self.cart.constraints.no_rotation:
            body = self.cart.inertia
            theta[1:N_PHI], std[1:N_PHI] = [*body.com, body.about_com], self._prior_std[1:N_PHI]
        return {
            name: ParameterEstimate(value, deviation, unit, known)
            for (name, unit), value, deviation, known in zip(
                self._names, theta.tolist(), std.tolist(), learned.tolist(), strict=True
            )
        }

    def _has_shrunk(self, covariance: Array) -> np.ndarray:
        """Whether the filter's own coordinate behind each parameter (p,) is known better than at first: a standard
        deviation of a physical value also shrinks where the value runs away."""
        share = np.ones(len(self._full))
        share[self.free] = np.sqrt(np.diagonal(covariance) / np.diagonal(self.first_covariance))
        share[:N_PHI] = share[list(self._chart.order)]
        return share < IDENTIFIABLE_SHARE

    def _to_coordinates(self, covariance: Array, block: Array) -> Array:
        full = self._tamed(block)
        inverse = np.eye(len(full))
        inverse[:N_PHI, :N_PHI] = np.linalg.inv(self._chart.jacobian(full[:N_PHI]))
        return np.asarray((inverse @ covariance @ inverse.T)[np.ix_(self.free, self.free)])
