"""What rows have taught so far: recursive least squares in information form, with a prior and forgetting.

Unknown: the free parameters, the wrenches' delay (s), what is wrong with nu where the last block
ended, and the noise that it shares with the next one. These two, the link, are handed from row to row, so that
neighbours' common noise is counted once. What rows add up to is told without what noise in their slopes does
(`kernels/slope_noise.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np

from cartgrasp.errors import UsageError
from cartgrasp.frames import Array
from cartgrasp.shallow_copy import shallow_copy

from ...gaussian import Gaussian
from ..kernels import belief as kernels
from ..kernels.jit import Indices
from ..kernels.row_algebra import FilteredRow
from ..kernels.slope_noise import SlopeNoise
from .mass_products import LearnedParameters, MassProducts

WRENCH_DELAY_STD = 0.03
"""s, of how late wrenches are, beyond `NOMINAL_DELAY_PERIODS`: clocks of sensors that no trigger shares are off by that
much."""
ROW_FORGETTING_FACTOR = 0.9992
"""Share that is kept of the information about what a row asks; with ten rows a second, 2 min are remembered."""
ROW_GATE = 12.0
"""Normalised squares, by component, beyond which a row pulls less."""
ROW_REJECTION_GATE = 1e6
"""And beyond which it is no measurement."""


class Innovation(NamedTuple):
    """The innovation of a row, of a `value` (n,) with its covariance, and its normalised square; `of_known` (n, n) is
    the covariance if parameters were known, of which white noise of wrenches makes `of_wrenches` (n, n). What it says
    of a change of the free parameters (f,) since before it is a score (f,), which varies by the information (f, f), and
    which the change moves by as much without what noise in slopes makes of that, `by_noise` (f, f).

    `in_own` is the value (n,) with noise in its slopes as it is, its covariance and that if parameters were known, with
    noise of the motion as the belief's own masses make it."""

    square: float
    pull: Array
    information: Array
    by_noise: Array
    value: Array
    covariance: Array
    of_known: Array
    in_own: tuple[Array, Array, Array]
    of_wrenches: Array

    def log_likelihood(self, mean: Array | float = 0.0, more: Array | float = 0.0) -> float:
        """The log-likelihood but for a constant, with something of this mean (n,) and covariance (n, n) beside. Beyond
        the gate, the noise is widened to it."""
        return float(log_likelihood(self.value - mean, self.covariance + more))

    def quasi_log_likelihood(self, mean: Array | float = 0.0, more: Array | float = 0.0) -> float:
        """The same to compare beliefs of different masses by. What noise of the motion does to a row goes with the
        mass, so that likelihoods are larger of less of it, while what noise alone makes tells nothing of it. With the
        noise of the belief's own mass, and its determinant left out, the square's expectation is the same of all."""
        spread = self.in_own[1] + more
        return float(log_likelihood(self.in_own[0] - mean, spread) + 0.5 * np.linalg.slogdet(self.in_own[2])[1])

    def log_likelihoods(self, more: Array) -> Array:
        """The same with something of each covariance (g, n, n) beside."""
        return log_likelihood(self.value, self.covariance + more)


def log_likelihood(value: Array, spread: Array, gate: float = ROW_GATE) -> Array:
    """The log-likelihood of a value (n,), but for a constant, with each covariance (..., n, n), widened to the gate."""
    n = len(value)
    square = np.linalg.solve(spread, value[:, None])[..., 0] @ value
    scale = np.maximum(1.0, square / (gate * n))
    return np.asarray(-0.5 * (square / scale + n * np.log(scale) + np.linalg.slogdet(spread)[1]))


class RegressionBelief:
    """Parameters are `free` (indices) of p, `first` (f,) with their covariance, and the others as `given` (p,); a row
    has n components. What is believed are the products."""

    def __init__(self, free: Indices, first: Gaussian, n: int, given: Array, products: MassProducts) -> None:
        self._free, self._n, self._k, self._products, self._given = free, n, len(free) + 1, products, given
        information = np.zeros((self._k, self._k))
        try:
            first = products.belief(first, free, given)
            information[:-1, :-1] = np.linalg.inv(first.covariance)
            information[-1, -1] = WRENCH_DELAY_STD**-2
            _inverse(information)
        except np.linalg.LinAlgError as error:
            why = "the cart's mass, CoM and inertia are too far apart to be learned; look for numbers not in SI units"
            raise UsageError(f"first guess: {why}") from error
        self._known, self._noise = _given(information, np.append(first.mean, 0.0), self._k)

    def copy(self) -> Self:
        return shallow_copy(self)

    @property
    def parameters(self) -> Gaussian:
        """The free ones."""
        told = self.concluded()
        return Gaussian(told.theta[self._free], told.covariance[np.ix_(self._free, self._free)])

    def concluded(self) -> LearnedParameters:
        """The parameters, of which those that are not free are given."""
        return self._products.factors_of(LearnedParameters(*self._concluded[1]))

    @property
    def _concluded(self) -> tuple[kernels.Belief, tuple[Array, Array, Array, float]]:
        return kernels.concluded(self._known, self._noise, self._given, self._free)

    @property
    def solved(self) -> Gaussian:
        """The belief of the free parameters, the delay and the link, if there is one."""
        information, pull = self._concluded[0]
        covariance = _inverse(information)
        return Gaussian(covariance @ pull, covariance)

    def update(self, row: FilteredRow, at: Array) -> Innovation:
        """Takes in a row around parameters (p,)."""
        row, at = self._products.of_row(row, at), self._products.products(at)
        known = self._known, self._noise
        (self._known, self._noise), told = kernels.absorbed(
            known, row, at, self._free, (ROW_FORGETTING_FACTOR, ROW_GATE, ROW_REJECTION_GATE)
        )
        innovation = Innovation(*told, row.of_wrenches)
        if not innovation.square < ROW_REJECTION_GATE * self._n:
            self.drop_link()
        return innovation

    def drop_link(self) -> None:
        """The next row does not begin where the last one ended."""
        if len(self._known[1]) > self._k:
            (information, pull), k = self._known, self._k
            across = information[k:, :k]
            gained = np.linalg.solve(information[k:, k:], np.column_stack([across, pull[k:]]))
            left = information[:k, :k] - across.T @ gained[:, :k]
            self._known = (left + left.T) / 2, pull[:k] - across.T @ gained[:, k]

    def open(self, added: Array) -> None:
        """Adds to the covariance of the free products, (f, f); how late wrenches are was told with others, too."""
        now = self.solved
        m = self._k - 1
        covariance = now.covariance.copy()
        covariance[:m, :m] += added
        covariance[m, m] += WRENCH_DELAY_STD**2
        self.believe(now.mean, covariance)

    def believe(self, mean: Array, covariance: Array) -> None:
        """Replaces what was believed."""
        self._known, self._noise = _given(_inverse(covariance), mean, self._k)


def _given(information: Array, mean: Array, k: int) -> tuple[tuple[Array, Array], SlopeNoise]:
    """A belief whose first k unknowns no row has taught yet."""
    covariance = _inverse(information)[:k, :k].copy()
    noise = SlopeNoise(np.zeros((k, k)), np.zeros(1), mean[:k].copy(), covariance, _inverse(covariance))
    return (information, information @ mean), noise


class Unlinked(NamedTuple):
    """A belief without its link, and what it says of the free parameters and the delay."""

    belief: RegressionBelief
    solved: Gaussian

    @classmethod
    def of(cls, belief: RegressionBelief) -> Unlinked:
        found = belief.copy()
        found.drop_link()
        return cls(found, found.solved)


def mixture(beliefs: Sequence[Unlinked], shares: Array, told: int) -> RegressionBelief:
    """The mixture of several beliefs with shares: the mean of the one that is `told`, and the spread of all about
    it."""
    mean = beliefs[told].solved.mean
    spread = np.zeros_like(beliefs[0].solved.covariance)
    for share, (_, own) in zip(shares.tolist(), beliefs, strict=True):
        spread += share * (own.covariance + np.outer(own.mean - mean, own.mean - mean))
    found = beliefs[0].belief.copy()
    found.believe(mean, spread)
    return found


def _inverse(matrix: Array) -> Array:
    """The inverse of a positive definite matrix with mixed units."""
    scale = np.sqrt(np.diagonal(matrix))
    found = np.linalg.inv(matrix / np.outer(scale, scale)) / np.outer(scale, scale)
    return np.asarray((found + found.T) / 2)
