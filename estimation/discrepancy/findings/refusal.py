"""Whether a refit foretells stretches that it did not see worse than the first guess: then it is no better, whatever
its likelihood says. And whether a model is surely farther from them than noise takes it."""

from __future__ import annotations

import numpy as np

from cartgrasp.errors import DataError
from cartgrasp.frames import Array
from cartgrasp.model import CartModel

from ..search.model import Model
from .gap import DISAGREEMENT_NOISE_RATIO
from .held_out import floor_rollouts, fold_starts, held_out_rollouts
from .rollouts import HORIZONS, Rollouts, joined, rollouts

MAX_REFIT_ERROR_RATIO = 1.05
"""Largest error of a refit, as a multiple of the first guess's, where too little moves to tell a standard error."""
REFIT_ERROR_SIGMAS = 2.0
"""Standard errors of the mean by which squares are larger: one chance in forty."""
ERROR_BLOCK_INTERVAL, MIN_ERROR_BLOCKS = 3.0, 3
"""Time (s) over which errors of rollouts are taken to be related; and fewest such times that tell a standard error."""
REFUSAL_HORIZON_INDEX = 1


def refused(model: Model, guess: CartModel) -> str:
    """Why the refit is no use; empty where it is of use, or too little moves to tell."""
    block = _blocks(model)
    if not len(block):
        return ""
    with np.errstate(all="ignore"):  # what runs away is told by its squares
        of_guess = joined([rollouts(balances, guess, first) for balances, _, first in fold_starts(model)])
        squares = [_squares(model, rolled) for rolled in (of_guess, held_out_rollouts(model))]
    before, after = (float(np.sqrt(one.mean())) for one in squares)
    score = _score(squares[1] - squares[0], block)
    if after <= MAX_REFIT_ERROR_RATIO * before if score is None else score < REFIT_ERROR_SIGMAS:
        return ""
    # no farther off than noise takes a right one
    if after <= DISAGREEMENT_NOISE_RATIO * floor_rollouts(model).gaps()[REFUSAL_HORIZON_INDEX]:
        return ""
    return (
        f"the fit foretells unseen stretches worse than the first guess: {1e3 * after:.1f} mm off after "
        f"{HORIZONS[REFUSAL_HORIZON_INDEX]:g} s, not {1e3 * before:.1f} mm; the first guess stays"
    )


def is_beyond(model: Model, floor: float) -> bool:
    """Whether a model's rollouts are surely farther from unseen stretches than noise takes them (m); where too little
    moves to tell, that they are farther is enough."""
    score = _score(_squares(model, held_out_rollouts(model)) - floor**2, _blocks(model))
    return score is None or score > REFIT_ERROR_SIGMAS


def _squares(model: Model, rolled: Rollouts) -> Array:
    """Squares (n,) of the distances of rollouts from the model's stretches, fold after fold."""
    squares = np.asarray((rolled.error[:, REFUSAL_HORIZON_INDEX, :2] ** 2).sum(axis=1))
    if not np.isfinite(squares).all():
        names = ", ".join(balances.name for balances in model.logs)
        raise DataError(f"{names}: simulations run away from it; look for numbers that are not in SI units")
    return squares


def _blocks(model: Model) -> np.ndarray:
    """Blocks (n,) to which the rollouts belong, fold after fold."""
    found, count = [np.zeros(0, dtype=int)], 0
    for balances, _, first in fold_starts(model):
        own = ((balances.motion.time[first] - balances.motion.time[0]) // ERROR_BLOCK_INTERVAL).astype(int)
        found.append(count + own)
        count += int(own.max(initial=-1)) + 1
    return np.concatenate(found)


def _score(differences: Array, block: np.ndarray) -> float | None:
    """The mean of differences (n,) over its standard error, by blocks that are independent; None of too few."""
    names, own = np.unique(block, return_inverse=True)
    if len(names) < MIN_ERROR_BLOCKS:
        return None
    centred = differences - differences.mean()
    sums = np.bincount(own, centred)
    error = np.sqrt((sums**2).sum() * len(names) / (len(names) - 1)) / len(differences)
    return float(differences.mean() / max(error, 1e-300))
