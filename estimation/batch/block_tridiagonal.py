"""Positive definite block tridiagonal matrices: what chains of states give, solved in banded form."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from cartgrasp.frames import Array


@final
@dataclass(frozen=True)
class BlockTridiagonal:
    """Blocks (n, d, d) on the diagonal, and (n - 1, d, d) below it."""

    diagonal: Array
    below: Array

    @classmethod
    def zeros(cls, n: int, d: int) -> BlockTridiagonal:
        return cls(np.zeros((n, d, d)), np.zeros((n - 1, d, d)))

    @classmethod
    def of_pairs(cls, first: Array, second: Array, weights: Array) -> BlockTridiagonal:
        """`sum Jᵀ W J` over residuals between neighbours, with partials (n - 1, k, d) by the first and by the second
        of a pair, and weights (n - 1, k, k)."""
        n, _, d = first.shape
        of_first, of_second = np.swapaxes(first, 1, 2) @ weights, np.swapaxes(second, 1, 2) @ weights
        diagonal = np.zeros((n + 1, d, d))
        diagonal[:-1] += of_first @ first
        diagonal[1:] += of_second @ second
        return cls(diagonal, of_second @ first)

    def __add__(self, other: BlockTridiagonal) -> BlockTridiagonal:
        return BlockTridiagonal(self.diagonal + other.diagonal, self.below + other.below)

    def with_pairs(self, nodes: np.ndarray, first: Array, second: Array, weights: Array) -> BlockTridiagonal:
        """With `Jᵀ W J` of rows (m,) between a node and the next: partials (m, f, d) by both, and weights (m, f, f)."""
        from .chain_sums import add_pairs

        found = BlockTridiagonal(self.diagonal.copy(), self.below.copy())
        add_pairs(found.diagonal, found.below, nodes, (first, second, weights))
        return found

    def factor(self) -> Factor:
        n, d, _ = self.diagonal.shape
        chain = np.zeros((n, d, 2 * d))
        for column in range(d):
            chain[:, column, : d - column] = self.diagonal[:, column:, column]
            chain[:-1, column, d - column : 2 * d - column] = self.below[:, :, column]
        bands = chain.reshape(n * d, 2 * d).T
        return Factor(cholesky_banded(bands, overwrite_ab=True, lower=True))


@final
@dataclass(frozen=True)
class Factor:
    """Cholesky's, lower, in banded form (2 d, n d)."""

    bands: Array

    @cached_property
    def chain(self) -> Array:
        """(n d, 2 d): each column from its diagonal on."""
        return np.ascontiguousarray(self.bands.T)

    def solve(self, right: Array) -> Array:
        """Of a right-hand side (n, d, ...)."""
        flat = right.reshape(self.bands.shape[1], -1)
        return np.asarray(cho_solve_banded((self.bands, True), flat, check_finite=False)).reshape(right.shape)

    @property
    def log_determinant(self) -> float:
        return 2.0 * float(np.log(self.bands[0]).sum())
