"""The compiled half of `BlockTridiagonal.with_pairs`, which tests compare with sums of small matrices."""

from __future__ import annotations

from pathlib import Path

from cartgrasp.compiling import OPTIONS, cached_as, digest
from cartgrasp.frames import Array
from cartgrasp.kernels.jit import Ints

entry = cached_as(digest([Path(__file__).read_bytes()]), {**OPTIONS, "fastmath": {"contract"}})


@entry
def add_pairs(diagonal: Array, below: Array, nodes: Ints, pairs: tuple[Array, Array, Array]) -> None:
    """To blocks (n, d, d) and (n - 1, d, d), `Jᵀ W J` of rows (m,) between a node and the next: partials (m, f, d) by
    both, and weights (m, f, f)."""
    first, second, weights = pairs
    m, f, d = first.shape
    for i in range(m):
        at = nodes[i]
        for a in range(f):
            for b in range(f):
                weight = weights[i, a, b]
                for s in range(d):
                    share = weight * first[i, a, s]
                    if share != 0.0:
                        for t in range(d):
                            diagonal[at, s, t] += share * first[i, b, t]
                    share = weight * second[i, a, s]
                    if share != 0.0:
                        for t in range(d):
                            diagonal[at + 1, s, t] += share * second[i, b, t]
                            below[at, s, t] += share * first[i, b, t]
