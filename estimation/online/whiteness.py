"""Whether what an estimator did not foretell is white.

Innovations of a right model are independent of one another (Kailath, 1968), so that over any stretch the square of
their sum is what their variances add up to. Where a model lacks something they go on pulling the same way: sums grow,
however small single squares are beside noise that was told too large, and deviations are as much too small.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cartgrasp.frames import Array

INNOVATION_SPAN = 3.0
"""s, over which innovations are summed."""
MAX_REMEMBERED_SPANS = 10.0
"""Spans that are remembered; half as many speak for the model before there is one."""
COLOURED_SQUARES_RATIO, COLOURED_SIGMAS = 2.0, 5.0
"""Times what white noise makes of squares of sums, and standard deviations of their mean, beyond which it is none."""
MIN_EIGENVALUE_RATIO = 1e-9
"""Share of the largest eigenvalue below which information is rounding."""


@dataclass(frozen=True)
class Whiteness:
    """Sums over the stretch that began last: of innovations, each as it pulls at some numbers (k,), and of the variance
    (k, k) of that; and of the stretches before it the mean square, 1 of white innovations, with its dimension."""

    begun: float = -math.inf
    pull: Array | float = 0.0
    variance: Array | float = 0.0
    level: float = 1.0
    spans: float = MAX_REMEMBERED_SPANS / 2
    dimension: int = 1

    def and_then(self, time: float, pull: Array, variance: Array) -> Whiteness:
        """The sums with one more innovation."""
        more = replace(self, pull=self.pull + pull, variance=self.variance + variance)
        if self.begun == -math.inf:
            return replace(more, begun=time)
        return more if time - self.begun < INNOVATION_SPAN else more._over(time)

    def _over(self, time: float) -> Whiteness:
        """The mean square with a stretch that has ended."""
        variance, pull = np.atleast_2d(self.variance), np.atleast_1d(self.pull)
        if not variance.any():
            return self.interrupted()
        scale = np.sqrt(np.maximum(np.diagonal(variance), 1e-300))
        known, axes = np.linalg.eigh(variance / np.outer(scale, scale))
        seen = known > MIN_EIGENVALUE_RATIO * known[-1]
        square = float((((axes.T @ (pull / scale)) ** 2)[seen] / known[seen]).mean())
        spans = min(self.spans + 1.0, MAX_REMEMBERED_SPANS)
        return Whiteness(time, 0.0, 0.0, self.level + (square - self.level) / spans, spans, int(seen.sum()))

    def interrupted(self) -> Whiteness:
        """The sums without those since the last stretch: after it, something else is believed."""
        return replace(self, begun=-math.inf, pull=0.0, variance=0.0)

    @property
    def chance(self) -> float:
        """Standard deviation of the mean square of white innovations."""
        return math.sqrt(2.0 / (self.dimension * self.spans))

    @property
    def is_coloured(self) -> bool:
        return self.level > max(COLOURED_SQUARES_RATIO, 1.0 + COLOURED_SIGMAS * self.chance)
