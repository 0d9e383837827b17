"""The parameters inside the filter's state: which are free, in what coordinates, and how they are reported."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI, Inertia
from cartgrasp.model import CartModel
from cartgrasp.motion import ParameterEstimate

from ...parameter_report import ParameterReport
from ...prior import Prior
from ..load_change import load_covariance
from .mobility import BodyLimits, build_chart

LEAST_MASS_SHARE, LEAST_INERTIA_SHARE = 0.1, 0.05
LARGEST_MASS_SHARE = 6.0
FARTHEST = 3.0
"""CoM and radius of gyration stay within this many of the prior's CoM standard deviations."""
ROUNDS = 5


class ParameterBlock:
    """Between the free coordinates (f,) that the filter carries and the model's parameters (p,)."""

    def __init__(self, cart: CartModel, prior: Prior) -> None:
        self.cart, self.prior = cart, prior
        self.free = prior.free(cart)
        self._chart = build_chart(cart.rolling)
        self._full = cart.parameters.copy()
        self._full[:N_PHI] = self._chart.coordinates(cart.inertia.phi)
        self.first = self._full[self.free]
        self._limits = limits = _limits(cart.inertia, prior)
        body = limits.mass, limits.com_x, limits.com_y, limits.inertia
        self._report = ParameterReport(cart, prior, body)
        self._effect_bounds = [(p.lower, p.upper) for effect in cart.effects for p in effect.parameters]
        places = {int(i): k for k, i in enumerate(self.free)}
        order = (*self._chart.clamped, *range(N_PHI, len(self._full)))
        self._clamped = tuple((places[i], i) for i in order if i in places)

    @cached_property
    def first_covariance(self) -> Array:
        """Of the first guess, (f, f), in the filter's coordinates."""
        return self._to_coordinates(self.prior.covariance(self.cart), self.first)

    def theta(self, block: Array) -> Array:
        """The model's parameters (p,) of a physical block."""
        full = self._coordinates(block)
        full[:N_PHI] = self._chart.phi(full[:N_PHI])
        return full

    def jacobian(self, block: Array) -> Array:
        """Partials (p, f) of `theta`."""
        full = self._coordinates(block)
        partials = np.eye(len(full))
        partials[:N_PHI, :N_PHI] = self._chart.jacobian(full[:N_PHI])
        return partials[:, self.free]

    def model_covariance(self, block: Array, covariance: Array) -> Array:
        """Of `theta`, (p, p), from that of the block, (f, f)."""
        jacobian = self.jacobian(block)
        return np.asarray(jacobian @ covariance @ jacobian.T)

    def nearest_physical(self, block: Array, covariance: Array) -> Array:
        """The block itself if a cart can have it: effects within their bounds, m > 0, J m > |m d|² (physics 18);
        else the most likely one, given its covariance (f, f): what is believed together moves together."""
        for _ in range(ROUNDS):
            inside = self._conditioned(block, covariance)
            if inside is block:
                return block
            block = inside
        return self._conditioned(block, np.eye(len(block)))

    def _conditioned(self, block: Array, covariance: Array) -> Array:
        """Each coordinate that is out of bounds put on its bound, one after the other."""
        full = self._coordinates(block)
        for k, i in self._clamped:
            low, high = self._chart.bounds(i, full, self._limits) if i < N_PHI else self._effect_bounds[i - N_PHI]
            value = full[i]
            if not low <= value <= high:
                spread = covariance[:, k] / covariance[k, k]
                block = block + spread * (min(max(value, low), high) - value)
                full = self._coordinates(block)
        return block

    def _coordinates(self, block: Array) -> Array:
        full = self._full.copy()
        full[self.free] = block
        return full

    def load_covariance(self, block: Array) -> Array:
        """What a load change may add, (f, f)."""
        covariance = load_covariance(self.cart, self.prior, float(self.theta(block)[0]))
        return self._to_coordinates(covariance, block)

    def report(self, block: Array, covariance: Array) -> dict[str, ParameterEstimate]:
        """The parameters by name, with standard deviations and whether this motion has taught them."""
        share = np.ones(len(self._full))
        share[self.free] = np.sqrt(np.diagonal(covariance) / np.diagonal(self.first_covariance))
        share[:N_PHI] = share[list(self._chart.order)]
        return self._report.of(self.theta(block), self.model_covariance(block, covariance), share)

    def _to_coordinates(self, covariance: Array, block: Array) -> Array:
        full = self._coordinates(block)
        inverse = np.eye(len(full))
        inverse[:N_PHI, :N_PHI] = np.linalg.inv(self._chart.jacobian(full[:N_PHI]))
        return np.asarray((inverse @ covariance @ inverse.T)[np.ix_(self.free, self.free)])


def _limits(body: Inertia, prior: Prior) -> BodyLimits:
    """What a cart like the first guess can have."""
    reach = FARTHEST * prior.com
    mass = (LEAST_MASS_SHARE * body.mass, LARGEST_MASS_SHARE * body.mass)
    (x, y), inertia = body.com, body.about_com
    most = max(4 * inertia, 2 * body.mass * reach**2)
    return BodyLimits(mass, (x - reach, x + reach), (y - reach, y + reach), (LEAST_INERTIA_SHARE * inertia, most))
