"""What one log says around some parameters, row by row and in sums over stretches of time."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from cartgrasp.frames import Array

from .block_tridiagonal import Factor

FEWEST_BLOCKS = 12
AT_ONCE = 28
"""Columns that are whitened together at most: more would leave the processor's cache."""
OUTLYING = 4.0
"""Times its share of the scatter that a stretch may have with full weight."""

MOST_NOISE = 0.7
"""Of what a motion seems to tell in some way: where more is noise, nobody knows whether anything is left."""
ASTRAY = 0.01
"""Of all that a log tells: less is noise anywhere."""
LEAST_TOLD = 1e-9
"""In a direction, of what parameters are told: less is round-off."""


@dataclass(frozen=True)
class Evidence:
    """Around some parameters and delay: of each stretch of time the information (b, p + 1, p + 1) and the pull
    (b, p + 1) on them. Where the model is right, pulls are independent, with the information as covariance; but for
    the share of the information that is noise of the motion alone, `noise` (b, p + 1, p + 1), and takes `drag`
    (b, p + 1) off the pulls (errors in variables)."""

    blocks: Array
    pulls: Array
    noise: Array
    drag: Array

    def part(self, which: np.ndarray) -> Evidence:
        """About some of the parameters, without noise: the corrected score of errors in variables `pull + drag` falls
        by `information - noise` from one parameter to the next, and scatters by the information; so what it tells is
        `(I - N) I⁻¹ (I - N)` (Nakamura 1990; Godambe). Stretches in which more seems to be noise than there is tell
        nothing: there, memories of the motion and of the same with more noise went other ways. Neither does the
        rest of what only they taught: it is not what a stretch teaches, but what its neighbours take from it, and may
        be negative."""
        blocks, noise = (each[:, which[:, None], which] for each in (self.blocks, self.noise))
        whole, lost = (np.diagonal(each, axis1=1, axis2=2) for each in (blocks, noise))
        astray = ((lost > whole) & (lost > ASTRAY * whole.sum(axis=0))).any(axis=1)
        blocks, noise = (np.where(astray[:, None, None], 0.0, each) for each in (blocks, noise))
        pulls = np.where(astray[:, None], 0.0, self.pulls[:, which] + self.drag[:, which])
        size = np.sqrt(np.maximum(whole.sum(axis=0), 0.0))
        scale = np.where(size > 0, size, 1.0)
        sizes, directions = np.linalg.eigh(blocks.sum(axis=0) / np.outer(scale, scale))
        told = sizes > LEAST_TOLD
        root = scale[:, None] * directions[:, told] * np.sqrt(sizes[told])
        inverse = (directions[:, told] / np.sqrt(sizes[told])).T / scale
        share, ways = np.linalg.eigh(inverse @ noise.sum(axis=0) @ inverse.T)
        kept = np.where(share < MOST_NOISE, 1 - np.clip(share, 0.0, 1.0), 0.0)
        keeps = root @ (ways * kept) @ ways.T @ inverse
        found = keeps @ blocks @ keeps.T, pulls @ keeps.T
        return Evidence(*found, np.zeros_like(blocks), np.zeros_like(pulls))

    def weighed(self, background: Array) -> tuple[Array, Array, float]:
        """Information and pull, with less weight for stretches that contradict themselves, and how many times as large
        as believed the noise variance is, where it matters: the pulls' scatter against the information, in the metric
        of the information with its background; 1 or more."""
        n, p = self.pulls.shape
        if n < FEWEST_BLOCKS:
            return self.blocks.sum(axis=0) if n else np.zeros((p, p)), self.pulls.sum(axis=0), 1.0
        kept = self.kept(background)
        information = kept.blocks.sum(axis=0)
        expected, scatter = kept._overlapping()._scatter(np.linalg.inv(information + background))
        taught = float(expected.sum())
        excess = float(scatter.sum()) / taught * n / max(n - taught, 1.0) if taught > 0 else 1.0
        return information, kept.pulls.sum(axis=0), max(1.0, excess)

    def kept(self, background: Array) -> Evidence:
        """With less weight for stretches that contradict themselves."""
        weights = self.weights(background)
        parts = (self.blocks, self.pulls, self.noise, self.drag)
        return Evidence(*(weights.reshape(-1, *[1] * (each.ndim - 1)) * each for each in parts))

    def weights(self, background: Array) -> Array:
        """Of stretches (b,): less than 1 where they contradict themselves."""
        if len(self.pulls) < FEWEST_BLOCKS:
            return np.ones(len(self.pulls))
        expected, scatter = self._scatter(np.linalg.inv(self.blocks.sum(axis=0) + background))
        ratio = scatter / np.maximum(expected, 1e-12)
        usual = max(1.0, float(np.median(ratio)))
        return np.minimum(1.0, OUTLYING * usual / np.maximum(ratio, 1e-12))

    def _overlapping(self) -> Evidence:
        """Of neighbours together: what is left of a jolt between them has one sign before it, and the other after."""
        parts = ((self.blocks, 2.0), (self.pulls, 2**0.5), (self.noise, 2.0), (self.drag, 2**0.5))
        return Evidence(*((each[1:] + each[:-1]) / share for each, share in parts))

    def _scatter(self, metric: Array) -> tuple[Array, Array]:
        """Of each stretch, what is expected and what is there."""
        expected = np.einsum("ij,bji->b", metric, self.blocks)
        return expected, np.einsum("bi,ij,bj->b", self.pulls, metric, self.pulls)


@dataclass(frozen=True)
class Linearisation:
    """Rows (m,) of a log around some parameters: time (m,), residual (m, f), its slopes `by` (m, f, p + 1) as they are
    in Evidence, weights (m, f, f) of a wrench's own noise, slopes `by_motion` (m, f, d) by the states of the smoother
    at `nodes` (m,) and those after, and the factor of what wrenches and smoother know of the motion."""

    time: Array
    nodes: np.ndarray
    residual: Array
    by: Array
    weights: Array
    by_motion: tuple[Array, Array]
    factor: Factor

    def whitened(self, columns: Array) -> Array:
        """Columns (m, f, k) times the inverse of the residual's covariance."""
        from .whitening import whiten

        found = np.empty(columns.shape)
        rows = (self.nodes, *self.by_motion, self.weights)
        parts = max(1, -(-columns.shape[2] // AT_ONCE))
        for own, white in zip(*(np.array_split(each, parts, axis=2) for each in (columns, found)), strict=True):
            whiten(self.factor.chain, rows, own, np.empty((len(self.factor.chain), own.shape[2])), white)
        return found

    def missed(self, errors: Array) -> Array:
        """What errors of the chain's states (n, d) make of the residual (m, f)."""
        first, second = (by[..., : errors.shape[1]] for by in self.by_motion)
        before, after = errors[self.nodes], errors[self.nodes + 1]
        return np.asarray(((first @ before[..., None]) + (second @ after[..., None]))[..., 0])

    @property
    def chi_squared(self) -> float:
        """Of the residual."""
        residual = self.residual[..., None]
        return float((residual * self.whitened(residual)).sum())

    def taught(self, columns: Array) -> tuple[Array, Array]:
        """By the residual, of what adds columns (m, f, k) to it: information (k, k) and pull (k,)."""
        sides = np.concatenate([columns, self.residual[..., None]], axis=2)
        sums = np.tensordot(columns, self.whitened(sides), ((0, 1), (0, 1)))
        return sums[:, :-1], sums[:, -1]

    def by_block(self, left: Array, right: Array, duration: float) -> Array:
        """`leftᵀ right` (b, k, l), summed over stretches of `duration` (s)."""
        f = left.shape[1]
        flat_left, flat_right = (np.reshape(side, (-1, side.shape[2])) for side in (left, right))
        return np.array(
            [flat_left[f * a : f * b].T @ flat_right[f * a : f * b] for a, b in pairwise(self.ends(duration))]
        )

    def ends(self, duration: float) -> list[int]:
        """Of stretches of `duration` (s) that have rows: where each begins, and the number of rows."""
        number = (self.time - self.time[0]) // duration
        return [0, *(np.flatnonzero(np.diff(number)) + 1).tolist(), len(number)]
