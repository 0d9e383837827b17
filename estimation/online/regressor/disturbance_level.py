"""How loud disturbances are, between what is declared and what may be there unseen, as rows tell it.

What noise of the motion does to a row's slopes is taken off by how it compares with that of the forces
(`kernels/slope_noise.py`). A disturbance that is thought too loud leaves too much of it, and masses come out too small.
So where a row has to bear with louder ones than there are as a rule, what is taken off is by the level that the
innovations of the last rows are most like: `log p(rows | level)`, in which older ones fade.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from cartgrasp.frames import Array

from .regression_belief import Innovation

N_DISTURBANCE_LEVELS = 6
MIN_LEVEL_RATIO = 1e-3
"""The lowest level, as a share of the highest, where none is declared."""
LEVEL_FORGETTING_FACTOR = 0.99
"""Share that is kept with each row of what older ones told; ten come a second."""


@dataclass(frozen=True, eq=False)
class DisturbanceLevel:
    """Densities (g,), N²s, of which the last is the highest, with the log-likelihood of each."""

    densities: Array
    log_likelihoods: Array

    @classmethod
    def between(cls, low: float, high: float) -> Self:
        """Each as likely as the other, from one level to another (N·√s); one alone where the first is not lower."""
        roots = (
            np.geomspace(max(low, MIN_LEVEL_RATIO * high), high, N_DISTURBANCE_LEVELS)
            if high > low
            else np.array([low])
        )
        return cls(roots**2, np.zeros(len(roots)))

    @property
    def highest(self) -> float:
        """N²s."""
        return float(self.densities[-1])

    @property
    def mean_density(self) -> float:
        """N²s, in the mean over all."""
        if len(self.densities) == 1:
            return self.highest
        likely = np.exp(self.log_likelihoods - self.log_likelihoods.max())
        return float(likely @ self.densities / likely.sum())

    def after(self, innovation: Innovation, one: Array) -> Self:
        """After a row that counted on the highest; its covariance (n, n) has `one` for each N²s."""
        if len(self.densities) == 1:
            return self
        more = (self.densities - self.highest)[:, None, None] * one
        return replace(
            self, log_likelihoods=LEVEL_FORGETTING_FACTOR * self.log_likelihoods + innovation.log_likelihoods(more)
        )
