"""What repeats, beside noise that only wanders about a period, as people's steps do, or a wheel that is not turned
evenly: a line stands out of the noise at neighbouring frequencies, a hump of noise does not (Thomson, 1982)."""

from __future__ import annotations

import numpy as np
from scipy.special import gammaln

from cartgrasp.frames import Array

from .laws import Law, seen_values
from .model import Model
from .periods import waves

NEIGHBOURS_PER_SIDE = 8
"""How many steps of what a log resolves the noise about a frequency is told by, on either side."""
NOISE_HUMP_NATS = 10.0
"""Nats beforehand against a hump of noise there: as much as a name has to gain."""
WAVE_RANK_TOLERANCE = 1e-9
"""Least share of the information on a wave of that on the other of its frequency."""


def beside_neighbours(model: Model, law: Law) -> float:
    """Log of the Bayes factor of a model's law that repeats, where noise about its frequencies may be louder than
    elsewhere."""
    assert law.period is not None
    step = 1 / max(float(np.ptp(seen_values(law.effects[0], [motion]))) for motion in model.motions)
    lines = np.array([k / law.period for k in law.effects[0].harmonics if k])
    sides = step * np.array([side for side in range(-NEIGHBOURS_PER_SIDE, NEIGHBOURS_PER_SIDE + 1) if side])
    around = lines[:, None] + sides
    apart = np.abs(around[..., None] - lines).min(axis=2)
    is_noise = (apart > 1.5 * step) & (around > step)
    squares, size = np.zeros(around.shape), 2 * len(law.effects)
    squares[is_noise] = _squares(model, law, around[is_noise])
    gained = [
        _evidence(noise, count) - _evidence(noise + line, count + size)
        for line, noise, count in zip(_lines(model, law), squares.sum(axis=1), size * is_noise.sum(axis=1), strict=True)
    ]
    own = model.score.covariance[place := _place(model, law), place]
    return float(sum(gained) + np.linalg.slogdet(own)[1] / 2 - np.log(law.std).sum())


def _evidence(squares: float, count: int) -> float:
    """Log density of so many normal values by their sum of squares, where their variance may be one, or any."""
    any_variance = gammaln(count / 2) - count / 2 * np.log(squares / 2) if count else -np.inf
    return float(np.logaddexp(-squares / 2, any_variance - NOISE_HUMP_NATS))


def _lines(model: Model, law: Law) -> list[float]:
    """Square of each harmonic's amplitudes in standard deviations."""
    place = _place(model, law)
    names, found = [key.rpartition("_")[2] for effect in law.effects for key in effect.keys], []
    for k in law.effects[0].harmonics:
        if k:
            is_its = law.basis[[name == f"{k:g}" for name in names]].any(axis=0)
            own = np.arange(place.start, place.stop)[is_its]
            fit, covariance = model.score.fit[own], model.score.covariance[np.ix_(own, own)]
            found.append(float(fit @ np.linalg.solve(covariance, fit)))
    return found


def _place(model: Model, law: Law) -> slice:
    """Where a law's numbers stand among the columns."""
    return next(at for own, at in zip(model.laws, model.law_places, strict=True) if own is law)


def _squares(model: Model, law: Law, frequencies: Array) -> Array:
    """Squares (v,), in standard deviations, of the amplitudes that a law would have at other frequencies (v,), each
    alone beside the model."""
    raw = [np.concatenate([waves(one, frequencies, b, model.cart) for one in law.effects], axis=3) for b in model.logs]
    white = model.whitened([one.reshape(*one.shape[:2], -1) for one in raw]) / model.score.scale[:, None]
    rows = (model.rows / model.score.scale[:, None]).reshape(-1, model.rows.shape[2])
    flat, base, left = white.reshape(len(rows), -1), rows[:, :-1], rows[:, -1] - rows[:, :-1] @ model.score.fit
    flat = flat - base @ np.linalg.solve(base.T @ base + np.diag(model.prior_std**-2.0), base.T @ flat)
    own = np.moveaxis(flat.reshape(len(rows), len(frequencies), -1), 1, 0)
    pull = own.swapaxes(1, 2) @ left
    found = np.linalg.pinv(own.swapaxes(1, 2) @ own, rcond=WAVE_RANK_TOLERANCE, hermitian=True)
    return np.asarray(np.einsum("vi,vij,vj->v", pull, found, pull))
