"""The residual wrench as a polygon: its values at nodes, with what noise lets them know of one another.

Means over stretches are steps in time, and noise that remembers would tell a step at once; what acts on a cart has
none. Straight lines from node to node can follow anything slower than a few hertz. What is known of neighbouring nodes
is known together: only then is a slow wave as sure as all the rows that it is in.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, cholesky_banded, solveh_banded

from cartgrasp.frames import Array

from ..batch.linearisation import Linearisation
from .weighing import weigh

STEP = 0.1
"""s, from one node to the next."""
REACH = 7
"""Nodes: how far noise reaches."""
WINDOW = 150
"""Nodes at a time."""
NEGLIGIBLE = 1e-3
"""Of a factor's diagonal."""
LOAD = 1e-6
"""Of what nodes tell in the mean: what one that tells nothing, as across a jolt, is taken to tell."""


@dataclass(frozen=True)
class Polygon:
    """Of some logs: nodes' times (b,) and logs (b,), values along the free directions (b, f), and of each direction the
    lower banded Cholesky factor (r, b) of the nodes' information, whatever the other directions' values are."""

    time: Array
    log: np.ndarray
    value: Array
    roots: tuple[Array, ...]

    @classmethod
    def of(cls, lines: Sequence[Linearisation]) -> Polygon:
        """Of each log's residual."""
        times, values, bands = zip(*(_nodes(line) for line in lines), strict=True)
        log = np.repeat(np.arange(len(lines)), [len(each) for each in times])
        f, band = values[0].shape[1], np.concatenate(bands, axis=1)
        roots = tuple(_root(_alone(band, f, i)) for i in range(f))
        return cls(np.concatenate(times), log, np.concatenate(values), roots)

    def whitened(self, direction: int, columns: Array) -> Array:
        """Columns at the nodes (..., b, k), so that their squares are weighed by what is known along a direction."""
        root = self.roots[direction]
        size = np.abs(root).max(axis=1)
        reach = int(np.flatnonzero(size > NEGLIGIBLE * size[0])[-1]) + 1
        stacked = np.ascontiguousarray(columns.reshape(-1, *columns.shape[-2:]))
        found = np.empty(stacked.shape)
        weigh(np.ascontiguousarray(root[:reach]), stacked, found)
        return found.reshape(columns.shape)

    def standard(self, direction: int) -> Array:
        """The whitened values (b,)."""
        return self.whitened(direction, self.value[:, direction, None])[:, 0]


def _nodes(line: Linearisation) -> tuple[Array, Array, Array]:
    """Times (b,) and values (b, f) of the nodes of one log, and their information, lower banded ((REACH + 1) f, b f).

    Nodes so far apart that noise does not reach are worked out together.
    """
    place = (line.time - line.time[0]) / STEP
    before = np.floor(place).astype(int)
    share, number = place - before, np.unique(np.concatenate([before, before + 1]))
    m, f, apart = *line.residual.shape, 2 * REACH + 2
    sides = np.zeros((m, f, apart * f + 1))
    for i in range(f):
        sides[np.arange(m), i, before % apart * f + i] = 1 - share
        sides[np.arange(m), i, (before + 1) % apart * f + i] = share
    sides[..., -1] = line.residual
    whitened, sums = line.whitened(sides), np.zeros((len(number), f, apart * f + 1))
    for nodes, weight in ((before, 1 - share), (before + 1, share)):
        np.add.at(sums, np.searchsorted(number, nodes), weight[:, None, None] * whitened)
    band = _banded(number, sums[..., :-1].reshape(len(number), f, apart, f))
    return number * STEP + line.time[0], _solved(band, sums[..., -1]), band


def _banded(number: np.ndarray, information: Array) -> Array:
    """Of nodes (b,), from that between each and the next or last ones of every group (b, f, groups, f)."""
    b, f, apart, _ = information.shape
    band = np.zeros(((REACH + 1) * f, b * f))
    for later in range(REACH + 1):
        there = np.searchsorted(number, number + later)
        first = np.flatnonzero(number[np.minimum(there, b - 1)] == number + later)
        second = there[first]
        own = information[first, :, number[second] % apart]
        own = (own + np.swapaxes(information[second, :, number[first] % apart], 1, 2)) / 2
        for i in range(f):
            for j in range(f):
                below = later * f + j - i
                if below >= 0:
                    band[below, first * f + i] = own[:, i, j]
    band[0] += LOAD * band[0].mean()
    return band


def _solved(band: Array, pull: Array) -> Array:
    """Values of the nodes (b, f)."""
    try:
        found = solveh_banded(band, pull.ravel(), lower=True)
    except LinAlgError:
        found = solveh_banded(_dominant(band), pull.ravel(), lower=True)
    return np.asarray(found).reshape(pull.shape)


def _alone(band: Array, f: int, direction: int) -> Array:
    """Of the nodes' information, lower banded, what is known of one direction when nothing is known of the others
    (r, b): they are taken out, a window of nodes at a time, since nodes far away have no part in it."""
    if f == 1:
        return band
    b, reach = band.shape[1] // f, len(band) // f
    found = np.zeros((reach, b))
    for first in range(0, b, WINDOW):
        low, high = max(0, first - 2 * reach), min(b, first + WINDOW + 2 * reach)
        part = _dense(band[:, low * f : high * f])
        own = np.arange(direction, len(part), f)
        others = np.setdiff1d(np.arange(len(part)), own)
        across = part[np.ix_(others, own)]
        left = part[np.ix_(own, own)] - across.T @ np.linalg.solve(part[np.ix_(others, others)], across)
        last = min(first + WINDOW, b)
        for below in range(reach):
            diagonal = np.diagonal(left, -below)[first - low : last - low]
            found[below, first : first + len(diagonal)] = diagonal
    return found


def _dense(band: Array) -> Array:
    """The symmetric matrix (n, n) of a lower band (r, n)."""
    n = band.shape[1]
    found = np.zeros((n, n))
    for below in range(min(len(band), n)):
        rows = np.arange(below, n)
        found[rows, rows - below] = found[rows - below, rows] = band[below, : n - below]
    return found


def _root(band: Array) -> Array:
    try:
        return np.asarray(cholesky_banded(band, lower=True))
    except LinAlgError:
        return np.asarray(cholesky_banded(_dominant(band), lower=True))


def _dominant(band: Array) -> Array:
    """With so much on the diagonal that it is a covariance's inverse, though noise reaches farther than the band."""
    beside, b = np.abs(band), band.shape[1]
    whole = beside[1:].sum(axis=0)
    for apart in range(1, min(len(band), b)):
        whole[apart:] += beside[apart, : b - apart]
    found = band.copy()
    found[0] = np.maximum(found[0], (1 + LOAD) * whole)
    return found
