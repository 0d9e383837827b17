"""Rollouts over stretches that no fit saw, beside what noise alone would do."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import wraps
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from cartgrasp.effects import ConstraintEffect
from cartgrasp.frames import Array
from cartgrasp.inertia import N_PHI
from cartgrasp.model import CartModel

from ...weak_form.balances import Balances
from ...weak_form.band import Band, band_in
from ...weak_form.coordinates import coordinates, with_coordinates
from ..search.model import Model, by_log
from .fast_noise import fast_noise
from .reported_mass import reported_mass
from .rollouts import HORIZONS, Rollouts, joined, noise_rollouts, rollouts, rollouts_beside, starts

HELD_OUT_FOLDS = 3
"""Every third stretch is simulated with what the others teach, in turn."""
NOISE_DRAWS = 3
CART_DRAWS = 8
"""Carts that are drawn of what a fit leaves open: they tell the size of what that does to a quarter."""
MAX_LOG_INERTIA_CHANGE = 1.0
"""Largest change of a logarithm of mass or inertia: what a fold says beyond is no linear matter any more."""


def cached_per_model(ask: Callable[[Model], Rollouts]) -> Callable[[Model], Rollouts]:
    """Asks once of each model, which never changes: several findings look at the same rollouts."""
    known = WeakKeyDictionary[Model, Rollouts]()

    @wraps(ask)
    def asked(model: Model) -> Rollouts:
        if model not in known:
            known[model] = ask(model)
        return known[model]

    return asked


@cached_per_model
def file_rollouts(model: Model) -> Rollouts:
    """Rollouts with the first guess."""
    return joined([rollouts(balances, model.guess, starts(balances)) for balances in model.logs])


@cached_per_model
def held_out_rollouts(model: Model) -> Rollouts:
    """Rollouts of each stretch with a cart that was fitted to the others."""
    carts = fold_carts(model)
    return joined([rollouts(balances, carts[k], first) for balances, k, first in fold_starts(model)])


@cached_per_model
def left_open_rollouts(model: Model) -> Rollouts:
    """How far rollouts of each stretch go from those of the cart that was fitted to the others, by what these leave
    open of it: carts are drawn of that."""
    generator, found = np.random.default_rng(0), list[Rollouts]()
    fits = [_fit_without(model, fold) for fold in range(HELD_OUT_FOLDS)]
    carts = [_cart_after(model, fit.step) for fit in fits]
    others = [[_cart_after(model, fit.drawn(generator)) for _ in range(CART_DRAWS)] for fit in fits]
    for balances, k, first in fold_starts(model):
        found += rollouts_beside(balances, carts[k], others[k], first)
    return joined(found)


def fold_carts(model: Model) -> list[CartModel]:
    """The cart as it is fitted without each fold."""
    return [_cart_after(model, _fit_without(model, fold).step) for fold in range(HELD_OUT_FOLDS)]


def fold_starts(model: Model) -> Iterator[tuple[Balances, int, np.ndarray]]:
    """Each log by fold, with the points from which rollouts begin in the fold's stretches."""
    for balances, own in _row_folds(model):
        first = starts(balances)
        fold = _folds_at(balances.motion.time[first] + HORIZONS[1] / 2, balances, own)
        yield from ((balances, k, first[fold == k]) for k in range(HELD_OUT_FOLDS) if (fold == k).any())


def _row_folds(model: Model) -> Iterator[tuple[Balances, np.ndarray]]:
    """Each log, with the fold of each of its rows (k,)."""
    for balances, block in zip(model.logs, by_log(model.folds.block, model.logs), strict=True):
        yield balances, model.folds.stretches[block] % HELD_OUT_FOLDS


def _folds_at(times: Array, balances: Balances, own: np.ndarray) -> np.ndarray:
    """Folds at times (n,), by those of a log's rows (k,); the first throughout a log without rows."""
    if not len(own):
        return np.zeros(len(times), dtype=int)
    return np.asarray(own[np.clip(np.searchsorted(balances.time, times), 0, len(own) - 1)])


@cached_per_model
def floor_rollouts(model: Model) -> Rollouts:
    """Rollouts of what noise alone would do to a right model."""
    generator, whole = np.random.default_rng(0), model.cart_with_laws
    return joined([noise_rollouts(b, model.cart, fast_noise(b, whole), generator, NOISE_DRAWS) for b in model.logs])


class _FoldFit(NamedTuple):
    """Step (q,) from a model to what the stretches of other folds teach, with the covariance of its `own` parameters:
    what happens once stays as it is."""

    step: Array
    own: np.ndarray
    covariance: Array

    def drawn(self, generator: np.random.Generator) -> Array:
        """A step (q,) that these stretches leave as likely."""
        step = self.step.copy()
        step[self.own] += np.linalg.cholesky(self.covariance) @ generator.standard_normal(len(self.own))
        return step


def _fit_without(model: Model, fold: int) -> _FoldFit:
    q, free = len(model.prior_std), np.flatnonzero(model.prior.free)
    kept = model.sums[:, model.folds.stretches % HELD_OUT_FOLDS != fold].sum(axis=1)
    joint = np.tensordot(model.score.scale**-2.0, kept, (0, 0))
    information, here = joint[:q, :q] + np.diag(model.prior_std**-2.0), np.zeros(q)
    here[: len(free)] = model.moved
    own = np.flatnonzero(np.append(~_transient_parameters(model.cart)[free], np.ones(q - len(free), dtype=bool)))
    step, covariance = np.zeros(q), np.linalg.inv(information[np.ix_(own, own)])
    step[own] = covariance @ (joint[:q, q] - information @ here)[own]
    if model.prior.free[0] and (known := _bands_without(model, fold)):  # what is told is what has to hold
        mass = float(coordinates(model.cart)[0] + step[0])
        told, std = reported_mass(mass, float(covariance[0, 0] ** 0.5), known)
        more = float(np.clip(told - mass, -MAX_LOG_INERTIA_CHANGE, MAX_LOG_INERTIA_CHANGE))
        along = covariance[:, 0] / covariance[0, 0]
        step[own] += along * more
        covariance = covariance + np.outer(along, along) * max(std**2 - covariance[0, 0], 0.0)
    return _FoldFit(step, own, covariance)


def _cart_after(model: Model, step: Array) -> CartModel:
    """The model's cart, with its laws, after a step (q,), which is shortened if it is no linear matter any more."""
    z, free = coordinates(model.cart), np.flatnonzero(model.prior.free)
    far = np.abs(step[: len(free)])[free < N_PHI].max(initial=0.0)
    step = step / max(far / MAX_LOG_INERTIA_CHANGE, 1.0)
    z[free] += step[: len(free)]
    cart = with_coordinates(model.cart, z)
    sizes = zip(model.cart.constraint_effects, step[len(free) :], strict=False)
    changed = {effect.key: effect.scaled(1.0 + float(more)) for effect, more in sizes}
    cart = replace(cart, effects=tuple(changed.get(effect.key, effect) for effect in cart.effects))
    return model.with_laws(cart, step)


def _bands_without(model: Model, fold: int) -> list[Band]:
    """Bands of the logs, in which the stretches of other folds tell the mass."""
    found = []
    for (balances, own), step in zip(_row_folds(model), model.band_steps, strict=False):
        if step is not None:
            every = balances.every(step)
            kept = _folds_at(every.time, balances, own) != fold
            found.append(band_in(every, model.cart_with_laws, model.guess, kept))
    return [band for band in found if band is not None]


def _transient_parameters(cart: CartModel) -> np.ndarray:
    """Parameters (p,) of what happens once: held out, it can't be learned."""
    once = [False] * N_PHI
    for effect in cart.effects:
        passes = effect.gate.passes and not isinstance(effect, ConstraintEffect)
        once += [passes] * len(effect.parameters)
    return np.array(once)
