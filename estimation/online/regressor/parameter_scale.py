"""Whether the scale of a cart's parameters is known: what wrenches have told of it.

All that a cart does to its hands is in proportion to its parameters. A cart that rolls without hands tells their ratios
alone, and noise of the motion then pulls all of them towards zero together, which solves `0 = Mr nu' + g(nu)` best. So
while the scale is not known, by the first guess or by wrenches that were felt, rows are not learned from. Of a scale s
a row of wrench F and noise R tells the information `Fᵀ R⁻¹ F` on log s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ...prior import Prior
from ..kernels.jit import Indices
from ..kernels.row_algebra import FilteredRow
from .mass_products import MASS_INDEX

KNOWN_LOG_SCALE_STD = 0.2
"""Standard deviation of log s."""
KNOWN_SCALE_SIGMAS = 3.0
"""Standard deviations by which what is told stands out of what noise alone would tell."""


@dataclass(frozen=True)
class ScaleInformation:
    """What is `lacking` at first, and what rows `told` since, of which noise alone would make so much `by_noise` (a
    variance)."""

    lacking: float
    told: float = 0.0
    by_noise: float = 0.0

    @classmethod
    def of(cls, cart: CartModel, prior: Prior, free: Indices) -> Self:
        """Nothing lacks where the mass is given. A force that is given, such as friction, is too weak beside noise of
        the motion, times the mass, to hold the others."""
        if MASS_INDEX not in free:
            return cls(0.0)
        return cls(KNOWN_LOG_SCALE_STD**-2 - (cart.inertia.mass / prior.deviations(cart)[MASS_INDEX]) ** 2)

    @property
    def is_known(self) -> bool:
        return self.lacking <= 0.0 or self.told - KNOWN_SCALE_SIGMAS * math.sqrt(self.by_noise) >= self.lacking

    def after(self, felt: Array, row: FilteredRow) -> Self:
        """After a row, over which a wrench (n,) was felt."""
        own = np.diagonal(row.noise)
        whole = own + (1.0 + row.fade**2) * np.diagonal(row.ends @ row.before @ row.ends.T)
        more, noise = float(((felt**2 - own) / whole).sum()), float((2.0 * (own / whole) ** 2).sum())
        return replace(self, told=self.told + more, by_noise=self.by_noise + noise)
