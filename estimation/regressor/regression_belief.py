"""What rows have taught so far: recursive least squares in information form, with a prior and forgetting.

Unknown: the free parameters, the wrenches' lateness (a share of a sample), what is wrong with nu where the last block
ended, and the noise that it shares with the next one. These two, the link, are handed from row to row, so that
neighbours' common noise is counted once.
"""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np

from cartgrasp.frames import Array

from ..gaussian import Gaussian, normalised_square, symmetric
from ..shallow import shallow
from .filtered_row import FilteredRow

LATENESS, LATENESS_STD = -0.25, 0.3
"""Of a sample period, beyond a wrench that is held to the next: that has 0, a mere sample -0.5."""
KEPT = 0.9992
"""Of the information about what a row asks; with ten rows a second, 2 min are remembered."""
GATE = 12.0
"""Normalised squares, by component, beyond which a row pulls less."""
ABSURD = 1e6
"""And beyond which it is no measurement."""
LEAST_SHARE = 1e-9
"""Of a row's noise: what is taken as shared where nothing is."""


class Surprise(NamedTuple):
    """Of a row: its normalised square, and what it says of a change of the free parameters (f,) since before it, as
    information (f, f) and its product with the change."""

    square: float
    pull: Array
    information: Array


class _Weighed(NamedTuple):
    """A row beside what is known `now`: its partials by that and by the link after it, its noise `alone`, the
    covariance of that link, its `own` noise with the link, and its news."""

    now: Gaussian
    before: Array
    after: Array
    alone: Array
    linking: Array
    own: Array
    news: Gaussian


class RegressionBelief:
    """Parameters are `free` (indices) of p, `first` (f,) with their covariance; a row has n components."""

    def __init__(self, free: np.ndarray, first: Gaussian, n: int) -> None:
        self._free, self._n, self._linking = free, n, 2 * n
        self._k = len(free) + 1
        information = np.zeros((self._k, self._k))
        information[:-1, :-1] = np.linalg.inv(first.covariance)
        information[-1, -1] = LATENESS_STD**-2
        self._information, self._pull = information, information @ np.append(first.mean, LATENESS)
        self._linked = False

    def copy(self) -> Self:
        other = shallow(self)
        other._information, other._pull = self._information.copy(), self._pull.copy()
        return other

    @property
    def parameters(self) -> Gaussian:
        """The free ones."""
        whole = self._solved
        m = self._k - 1
        return Gaussian(whole.mean[:m], whole.covariance[:m, :m])

    @property
    def lateness(self) -> float:
        return float(self._solved.mean[self._k - 1])

    @property
    def _solved(self) -> Gaussian:
        covariance = _inverse(self._information)
        return Gaussian(covariance @ self._pull, covariance)

    def absorb(self, row: FilteredRow, at: Array) -> Surprise:
        """Takes in a row around parameters (p,)."""
        found, k, n = self._weighed(row, at), self._k, self._linking
        news, spread = found.news.mean, found.news.covariance
        slopes = found.before[:, :k]
        square = float(normalised_square(news, spread))
        scale = max(1.0, square / (GATE * self._n))
        asked = np.linalg.solve(scale * spread, slopes[:, :-1]).T
        surprise = Surprise(square, asked @ news, asked @ slopes[:, :-1])
        if not square < ABSURD * self._n:
            self.unlink()
            return Surprise(square, 0.0 * surprise.pull, 0.0 * surprise.information)
        self._forget(slopes, scale * found.own, found.now)
        whole = np.zeros((k + 2 * n, k + 2 * n))
        whole[: k + n, : k + n] = self._information
        whole[k + n :, k + n :] = np.linalg.inv(found.linking)
        H = np.hstack([found.before, found.after])
        weight = np.linalg.inv(scale * found.alone)
        whole += H.T @ weight @ H
        value = news + found.before @ found.now.mean
        pull = np.concatenate([self._pull, np.zeros(n)]) + H.T @ weight @ value
        past, left = np.arange(k, k + n), np.r_[0:k, k + n : k + 2 * n]
        self._information, self._pull = _without(whole, pull, past, left)
        self._pull[:k] -= np.append(row.feigned[self._free], row.feigned[-1]) / scale
        return surprise

    def _weighed(self, row: FilteredRow, at: Array) -> _Weighed:
        if not self._linked:
            self._link(_linking(row, row.before))
        now, common = self._solved, np.eye(self._n)
        slopes = np.column_stack([row.slopes[:, self._free], row.slopes[:, -1]])
        before, after = np.hstack([slopes, -row.fade * row.ends, common]), np.hstack([row.ends, common])
        alone, linking = row.noise - 2 * row.shared, _linking(row, row.after)
        own = alone + after @ linking @ after.T
        news = row.residual + row.slopes[:, self._free] @ at[self._free] - before @ now.mean
        foreseen = Gaussian(news, before @ now.covariance @ before.T + own)
        return _Weighed(now, before, after, alone, linking, own, foreseen)

    def unlink(self) -> None:
        """The next row does not begin where the last one ended."""
        if self._linked:
            past, left = np.arange(self._k, self._k + self._linking), np.arange(self._k)
            self._information, self._pull = _without(self._information, self._pull, past, left)
            self._linked = False

    def open(self, added: Array) -> None:
        """Adds to the covariance of the free parameters, (f, f)."""
        now = self._solved
        m = self._k - 1
        covariance = now.covariance.copy()
        covariance[:m, :m] += added
        self._information = _inverse(covariance)
        self._pull = self._information @ now.mean

    def _link(self, before: Array) -> None:
        k, n = self._k, self._linking
        information = np.zeros((k + n, k + n))
        information[:k, :k], information[k:, k:] = self._information, np.linalg.inv(before)
        self._information, self._pull = information, np.concatenate([self._pull, np.zeros(n)])
        self._linked = True

    def _forget(self, slopes: Array, noise: Array, now: Gaussian) -> None:
        """Of what the row asks, and never more than it answers (after Kulhavý 1987): where nothing is excited nothing
        is forgotten, and what is left of the prior is not lost."""
        k = self._k
        root = np.linalg.inv(np.linalg.cholesky(noise))
        asked = root @ slopes
        known, directions = np.linalg.eigh(asked @ now.covariance[:k, :k] @ asked.T)
        taken = np.minimum((1 - KEPT) / np.maximum(known, 1e-300), 1.0)
        along = directions.T @ asked
        lost = along.T @ (taken[:, None] * along)
        self._information[:k, :k] -= lost
        self._pull[:k] -= lost @ now.mean[:k]


def _linking(row: FilteredRow, error: Array) -> Array:
    """Covariance (2 n, 2 n) of what is wrong with nu, given (n, n), and of noise that neighbours share."""
    n = len(error)
    covariance = np.zeros((2 * n, 2 * n))
    covariance[:n, :n], covariance[n:, n:] = error, row.shared + LEAST_SHARE * row.noise
    return covariance


def _without(information: Array, pull: Array, past: np.ndarray, left: np.ndarray) -> tuple[Array, Array]:
    """About those that are `left`, whatever the `past` ones are (Schur's complement)."""
    gain = np.linalg.solve(information[np.ix_(past, past)], information[np.ix_(past, left)]).T
    kept = information[np.ix_(left, left)] - gain @ information[np.ix_(past, left)]
    return symmetric(kept), pull[left] - gain @ pull[past]


def _inverse(matrix: Array) -> Array:
    """Of a positive definite one with mixed units."""
    scale = 1 / np.sqrt(np.diagonal(matrix))
    return symmetric(np.linalg.inv(matrix * np.outer(scale, scale)) * np.outer(scale, scale))
