"""What makes the noise of a log's rows white."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.linalg import solve_banded
from scipy.linalg.lapack import dtbtrs
from scipy.sparse import csr_array, dia_array

from cartgrasp.frames import Array

from .integrals import SPLINE_SUPPORT


@dataclass(frozen=True, eq=False)
class Whitening:
    """Whitening of a log's rows, by banded Cholesky factors of their covariance, in LAPACK's lower form. Each is
    (SPLINE_SUPPORT b, k b) of b balances that go together, row after row. `memory` (c,) is how much of one row's noise
    the next still has, where it is `linked` (k,). `counts` (k, c) is how much of each row's square noise makes: little,
    where anything may hold the cart and nothing does."""

    roots: tuple[Array, ...]
    memory: Array
    linked: np.ndarray
    counts: Array

    @cached_property
    def _parts(self) -> list[tuple[slice, Array]]:
        """The balances of each factor."""
        ends = np.cumsum([0, *(len(root) // SPLINE_SUPPORT for root in self.roots)]).tolist()
        return [(slice(*pair), root) for pair, root in zip(pairwise(ends), self.roots, strict=True)]

    @cached_property
    def _filter(self) -> tuple[Array, Array]:
        """Share of its predecessor that is taken off a row, and factor by which the rest is made louder (k, c)."""
        kept = self.linked[:, None] * self.memory
        return kept, (1.0 - kept**2) ** -0.5

    def __call__(self, columns: Array) -> Array:
        """Columns (k, c, ...) whitened."""
        found = np.empty_like(columns)
        for own, root in self._parts:
            part = columns[:, own]
            flat = part.reshape(part.shape[0] * part.shape[1], -1)
            found[:, own] = dtbtrs(root, flat, uplo="L")[0].reshape(part.shape)
        kept, gain = (each.reshape(*each.shape, *[1] * (columns.ndim - 2)) for each in self._filter)
        found[1:] = gain[1:] * (found[1:] - kept[1:] * found[:-1])
        return found

    def transposed(self, rows: Array) -> Array:
        """Rows (k, c) times the transpose of what whitens."""
        kept, gain = self._filter
        pulled = gain * rows
        pulled[:-1] -= kept[1:] * pulled[1:]
        parts = [dtbtrs(root, pulled[:, own].reshape(-1, 1), uplo="L", trans="T")[0] for own, root in self._parts]
        return np.hstack([part.reshape(len(rows), -1) for part in parts])

    def deviations(self, weights: csr_array) -> Array:
        """Standard deviations (b, c) that noise gives to weighted sums (b, k) of raw rows."""
        kept, gain = self._filter
        bands, variances = np.stack([np.vstack([np.zeros_like(gain[:1]), -(kept * gain)[1:]]), gain]), []
        for own, root in self._parts:
            count, size = own.stop - own.start, root.shape[1]
            factor = dia_array((root, -np.arange(len(root))), shape=(size, size)).tocsr()
            for i in range(count):
                each = (weights @ factor[i::count]).toarray().reshape(weights.shape[0], -1, count)
                pulled = [solve_banded((0, 1), bands[..., own.start + j], each[..., j].T) for j in range(count)]
                variances.append(np.sum(np.square(pulled), axis=(0, 1)))
        return np.asarray(np.sqrt(np.column_stack(variances)))

    def louder(self, times: Array) -> Whitening:
        """Whitening of noise that is `times` (c,) as large."""
        roots = []
        for own, root in self._parts:
            row = np.add.outer(np.arange(len(root)), np.arange(root.shape[1]))
            roots.append(root * times[own][row % (own.stop - own.start)])
        return replace(self, roots=tuple(roots))
