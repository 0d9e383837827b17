"""One score: the expected log predictive density of rows that a model has not seen.

Rows are whitened, so a Gaussian model's density of some rows given all others is a ratio of two evidences, and both
are functions of sums of products over blocks of time. Folds are dealt twice: pieces in turn (fair to what happens
once), and stretches one by one (fair to what must hold everywhere).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cartgrasp.frames import Array

N_SCORE_FOLDS = 5
MIN_PIECE_DURATION, MIN_STRETCH_DURATION = 0.6, 3.0
"""Durations (s) of a piece and of a stretch, at least."""
MAX_PIECES, MAX_STRETCHES = 1000, 20
"""Most pieces and most stretches of a log: more would only cost memory."""
MIN_RESIDUAL_SCALE = 1e-3
"""Smallest scale of residuals, in multiples of the noise by which rows are whitened: it keeps logs without noise
finite."""


@dataclass(frozen=True, eq=False)
class Folds:
    """Each row's `block` (k,), and the folds to which each block belongs (b,): that of `pieces`, dealt in turn, and
    that of `stretches`."""

    block: np.ndarray
    pieces: np.ndarray
    stretches: np.ndarray

    @classmethod
    def of(cls, time: Array, row_step: float) -> Folds:
        """Folds of the rows at times (k,)."""
        duration = float(time[-1] - time[0])
        piece = max(MIN_PIECE_DURATION, 2 * row_step, duration / MAX_PIECES)
        block = ((time - time[0]) // piece).astype(int)
        kinds, block = np.unique(block, return_inverse=True)
        long = max(MIN_STRETCH_DURATION, piece, duration / MAX_STRETCHES)
        return cls(block, kinds % N_SCORE_FOLDS, (kinds * piece // long).astype(int))

    @classmethod
    def joined(cls, parts: Sequence[Folds]) -> Folds:
        """Folds of several logs together: pieces are dealt in turn in each, stretches are each log's own."""
        first = np.cumsum([0, *(len(one.pieces) for one in parts)])
        stretch = np.cumsum([0, *(int(one.stretches.max()) + 1 for one in parts)])
        return cls(
            np.concatenate([one.block + at for one, at in zip(parts, first, strict=False)]),
            np.concatenate([one.pieces for one in parts]),
            np.concatenate([one.stretches + at for one, at in zip(parts, stretch, strict=False)]),
        )

    def sums(self, columns: Array) -> Array:
        """Products of whitened columns (k, c, q), by balance and block (c, b, q, q)."""
        count = len(self.pieces)
        ends = np.searchsorted(self.block, np.arange(count + 1))
        found = np.empty((columns.shape[1], count, columns.shape[2], columns.shape[2]))
        for b in range(count):
            own = columns[ends[b] : ends[b + 1]].swapaxes(0, 1)
            found[:, b] = own.swapaxes(1, 2) @ own
        return found

    def counted(self, counts: Array) -> Array:
        """Number of rows in each block (c, b), in which each row has the weight that it counts for (k, c)."""
        return np.array([np.bincount(self.block, own) for own in counts.T])


@dataclass(frozen=True, eq=False)
class Score:
    """Log predictive densities of pieces and stretches, left out one by one, their scales, and the fit."""

    pieces: Array
    stretches: Array
    scale: Array
    fit: Array
    covariance: Array


def scored(sums: Array, rows: Array, prior: Array, folds: Folds, scale: Array) -> Score:
    """Score from products of whitened columns, the residual last, summed over blocks (c, b, q + 1, q + 1), and row
    counts (c, b). `prior` has the columns' standard deviations (q,). `scale` (c,) is a first guess, near the
    model's."""
    total = sums.sum(axis=1)
    for _ in range(3):
        fit, covariance = _fit(total, prior, scale)
        scale = _scale(total, rows.sum(axis=1), fit, covariance, scale)
    fit, covariance = _fit(total, prior, scale)
    found, every = [], rows.sum(axis=1, keepdims=True)
    whole = log_evidence(total[:, None], prior, scale, every)
    for fold in (folds.pieces, folds.stretches):
        left, n = (np.stack([each[:, fold == f].sum(axis=1) for f in np.unique(fold)], axis=1) for each in (sums, rows))
        found.append(whole - log_evidence(total[:, None] - left, prior, scale, every - n))
    return Score(found[0], found[1], scale, fit, covariance)


def log_evidence(total: Array, prior: Array, scale: Array, rows: Array | float) -> Array:
    """Log evidence, up to a constant, of rows (c, ...) from sums (c, ..., q + 1, q + 1) of their columns' products."""
    joint = np.tensordot(scale**-2.0, total, (0, 0))
    q = len(prior)
    information = joint[..., :q, :q] + np.diag(prior**-2.0)
    pull = joint[..., :q, q]
    explained = (pull * np.linalg.solve(information, pull[..., None])[..., 0]).sum(axis=-1)
    size = np.linalg.slogdet(information)[1] + 2 * np.log(prior).sum()
    return np.asarray(-0.5 * (joint[..., q, q] - explained + size) - np.tensordot(np.log(scale), rows, (0, 0)))


def _fit(total: Array, prior: Array, scale: Array) -> tuple[Array, Array]:
    joint = np.tensordot(scale**-2.0, total, (0, 0))
    q = len(prior)
    covariance = np.asarray(np.linalg.inv(joint[:q, :q] + np.diag(prior**-2.0)), dtype=float)
    return covariance @ joint[:q, q], covariance


def _scale(total: Array, rows: Array, fit: Array, covariance: Array, scale: Array) -> Array:
    step = np.append(-fit, 1.0)
    left = np.einsum("i,cij,j->c", step, total, step)
    q = len(fit)
    used = np.einsum("ij,cji->c", covariance, total[:, :q, :q]) / scale**2
    return np.asarray(
        np.maximum(np.sqrt(np.maximum(left, 0.0) / np.maximum(rows - used, 0.5 * rows)), MIN_RESIDUAL_SCALE)
    )
