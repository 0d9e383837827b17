"""The compiled half of `Linearisation.whitened`: a chain's Cholesky factor, solved beside what leads in and out of it.

It finds `W c - W J (Jᵀ W J + Σ⁻¹)⁻¹ Jᵀ W c`, which tests compare with dense least squares.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from numba import njit

from cartgrasp.compiling import OPTIONS, F, cached_as, digest
from cartgrasp.frames import Array
from cartgrasp.kernels.jit import Ints

QUICK: dict[str, Any] = {**OPTIONS, "fastmath": {"contract"}}
entry = cached_as(digest([Path(__file__).read_bytes()]), QUICK)


def compiled(function: F) -> F:
    return njit(function, inline="always", **QUICK)  # type: ignore[no-any-return]


@compiled
def _add(to: Array, share: float, row: Array) -> None:
    for q in range(len(to)):
        to[q] += share * row[q]


@compiled
def _solve(chain: Array, d: int, through: Array) -> None:
    size = len(chain)
    for j in range(size):
        share = 1.0 / chain[j, 0]
        for q in range(through.shape[1]):
            through[j, q] *= share
        for k in range(1, min(2 * d - j % d, size - j)):
            _add(through[j + k], -chain[j, k], through[j])
    for j in range(size - 1, -1, -1):
        for k in range(1, min(2 * d - j % d, size - j)):
            _add(through[j], -chain[j, k], through[j + k])
        share = 1.0 / chain[j, 0]
        for q in range(through.shape[1]):
            through[j, q] *= share


@compiled
def _solve_one(chain: Array, d: int, through: Array) -> None:
    """As `_solve`, of one column, without loops over columns."""
    size = len(chain)
    for j in range(size):
        through[j, 0] /= chain[j, 0]
        for k in range(1, min(2 * d - j % d, size - j)):
            through[j + k, 0] -= chain[j, k] * through[j, 0]
    for j in range(size - 1, -1, -1):
        left = through[j, 0]
        for k in range(1, min(2 * d - j % d, size - j)):
            left -= chain[j, k] * through[j + k, 0]
        through[j, 0] = left / chain[j, 0]


@entry
def whiten(chain: Array, rows: tuple[Ints, Array, Array, Array], columns: Array, through: Array, found: Array) -> None:
    """`chain` (n d, 2 d) holds the factor's columns from their diagonal on; `rows` the states (m,) that the rows
    follow, slopes by these and by those after them (m, f, d), and weights (m, f, f). Columns (m, f, k) into `found`
    (m, f, k), with room for `through` (n d, k)."""
    nodes, first, second, weights = rows
    m, f, d = first.shape
    through[:] = 0.0
    found[:] = 0.0
    for i in range(m):
        before, after = nodes[i] * d, nodes[i] * d + d
        for a in range(f):
            for b in range(f):
                _add(found[i, a], weights[i, a, b], columns[i, b])
            for s in range(d):
                if first[i, a, s] != 0.0:
                    _add(through[before + s], first[i, a, s], found[i, a])
                if second[i, a, s] != 0.0:
                    _add(through[after + s], second[i, a, s], found[i, a])
    if through.shape[1] == 1:
        _solve_one(chain, d, through)
    else:
        _solve(chain, d, through)
    for i in range(m):
        before, after = nodes[i] * d, nodes[i] * d + d
        for b in range(f):
            for s in range(d):
                for a in range(f):
                    _add(found[i, a], -weights[i, a, b] * first[i, b, s], through[before + s])
                    _add(found[i, a], -weights[i, a, b] * second[i, b, s], through[after + s])
