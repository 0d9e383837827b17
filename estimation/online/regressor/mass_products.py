"""Coordinates in which what acts in proportion to the mass is linear.

A rolling resistance c, or a slope, pushes by `c m g`: while neither factor is known well, what a row that is linear in
m and c leaves out is the same in every row, and each row would count it as noise of its own. In the product `c m` a row
is linear, so that belief is held in products; what is told are the factors.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cartgrasp.effects import UnknownSlope
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel

from ...gaussian import Gaussian
from ...physical_set import MIN_MASS_RATIO
from ..kernels.jit import Indices
from ..kernels.row_algebra import FilteredRow

MASS_INDEX = 0
"""Its place among the parameters."""


class LearnedParameters(NamedTuple):
    """Parameters (p,), their covariance (p, p), and a root of it (p, f); and how late wrenches are (s)."""

    theta: Array
    covariance: Array
    root: Array
    wrench_delay: float


@dataclass(frozen=True, eq=False)
class MassProducts:
    """The products of the parameters at `by_mass` with the mass, which is taken to be at least `least` (kg). `usual` is
    by how much another floor changes the factors: not an unknown slope, or loads on their way would be slopes."""

    by_mass: Indices
    least: float
    usual: Array

    @classmethod
    def of(cls, cart: CartModel, free: Indices) -> MassProducts:
        """Where the mass is given, there is nothing to be told apart."""
        of_effects = [(effect, parameter) for effect in cart.effects for parameter in effect.parameters]
        by_mass = {N_PHI + i for i, (_, parameter) in enumerate(of_effects) if parameter.is_by_mass}
        scaled = np.array(sorted(by_mass & set(free.tolist())) if MASS_INDEX in free else [], dtype=np.int64)
        by_floor = [of_effects[i - N_PHI] for i in scaled.tolist()]
        usual = np.array([0.0 if isinstance(effect, UnknownSlope) else one.typical for effect, one in by_floor])
        return cls(scaled, MIN_MASS_RATIO * cart.inertia.mass, usual)

    def products(self, theta: Array) -> Array:
        """The parameters (p,) with products in place of the factors."""
        found = theta.copy()
        found[self.by_mass] *= max(theta[MASS_INDEX], self.least)
        return found

    def factors(self, products: Array) -> Array:
        """The parameters (p,) with factors in place of the products."""
        found = products.copy()
        found[self.by_mass] /= max(products[MASS_INDEX], self.least)
        return found

    def floor(self, theta: Array) -> Array:
        """Covariance (p, p) of the products, of what another floor changes."""
        found = np.zeros((len(theta), len(theta)))
        found[self.by_mass, self.by_mass] = (self.usual * max(theta[MASS_INDEX], self.least)) ** 2
        return found

    def jacobian(self, theta: Array) -> Array:
        """Partials (p, p) of the factors by the products, at factors (p,)."""
        found, at, mass = np.eye(len(theta)), self.by_mass, max(theta[MASS_INDEX], self.least)
        found[at, at] = 1.0 / mass
        found[at, MASS_INDEX] = -theta[at] / mass
        return found

    def by_factors(self, theta: Array) -> Array:
        """Partials (p, p) of the products by the factors: the inverse of `jacobian`."""
        found, at = np.eye(len(theta)), self.by_mass
        found[at, at] = max(theta[MASS_INDEX], self.least)
        found[at, MASS_INDEX] = theta[at]
        return found

    def of_row(self, row: FilteredRow, theta: Array) -> FilteredRow:
        """The row with its slopes by the products."""
        if not len(self.by_mass):
            return row
        n = len(theta)
        found, by = np.eye(n + 1), self.jacobian(theta)
        found[:n, :n] = by
        return row._replace(slopes=row.slopes @ found, by_rise=row.by_rise @ by)

    def factors_of(self, believed: LearnedParameters) -> LearnedParameters:
        """What is believed of the factors, from what is of the products."""
        if not len(self.by_mass):
            return believed
        theta = self.factors(believed.theta)
        by = self.jacobian(theta)
        return LearnedParameters(theta, by @ believed.covariance @ by.T, by @ believed.root, believed.wrench_delay)

    def belief(self, factors: Gaussian, free: Indices, theta: Array) -> Gaussian:
        """The belief of the free products (f,), from that of the free factors; the others are `theta` (p,)."""
        whole, places = theta.copy(), np.ix_(free, free)
        whole[free] = factors.mean
        by = self.by_factors(whole)[places]
        return Gaussian(self.products(whole)[free], by @ factors.covariance @ by.T)
