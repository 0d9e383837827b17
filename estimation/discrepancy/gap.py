"""The gap between simulation and measurement on stretches that no fit saw, beside what noise alone would do."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cartgrasp.effects import ConstraintEffect
from cartgrasp.effects.effect import Gate
from cartgrasp.errors import DataError
from cartgrasp.model import CartModel

from ..weak_form.balances import Balances
from ..weak_form.fit import coordinates, with_coordinates
from .fast_noise import fast_noise
from .model import Model
from .rollouts import HORIZONS, Rollouts, joined, noise_rollouts, rollouts, starts

FOLDS = 3
"""Every third stretch is simulated with what the others teach, in turn."""
DRAWS = 3
COORDINATES = ("along", "across", "heading")


@dataclass(frozen=True)
class Gap:
    """Root mean square error (m) of 1 s rollouts on stretches that no fit saw: of the nominal model, of the same
    refitted, with the effects added, and what noise alone would do; by coordinate (m, m, rad) and by horizon."""

    before: float
    refitted: float
    after: float
    noise_floor: float
    per_coordinate: dict[str, dict[str, float]]
    per_horizon: dict[str, dict[str, float]]

    def as_dict(self) -> dict[str, Any]:
        return {
            "metric": "root mean square distance after a 1 s rollout on held-out stretches, m",
            "before": self.before,
            "refitted": self.refitted,
            "after": self.after,
            "noise_floor": self.noise_floor,
            "per_coordinate": self.per_coordinate,
            "per_horizon": self.per_horizon,
        }


def held_out_rollouts(model: Model) -> Rollouts:
    """Each stretch with a cart that was fitted to the others."""
    carts = fold_carts(model)
    return joined([rollouts(balances, carts[k], first) for balances, k, first in fold_starts(model)])


def fold_carts(model: Model) -> list[CartModel]:
    """The cart as it is fitted without each fold."""
    return [_without(model, fold) for fold in range(FOLDS)]


def fold_starts(model: Model) -> Iterator[tuple[Balances, int, np.ndarray]]:
    """Of each log, by fold, the points from which rollouts begin in its stretches."""
    at = 0
    for balances in model.logs:
        own = model.folds.stretches[model.folds.block[at : at + len(balances.used)]]
        at += len(balances.used)
        first = starts(balances)
        middle = balances.motion.time[first] + HORIZONS[1] / 2
        fold = own[np.clip(np.searchsorted(balances.time, middle), 0, len(own) - 1)] % FOLDS if len(own) else first * 0
        yield from ((balances, k, first[fold == k]) for k in range(FOLDS) if (fold == k).any())


def cart_rollouts(model: Model, cart: CartModel) -> Rollouts:
    """Of one cart everywhere."""
    return joined([rollouts(balances, cart, starts(balances)) for balances in model.logs])


def floor_rollouts(model: Model) -> Rollouts:
    """What noise alone would do to a right model."""
    generator, found = np.random.default_rng(0), []
    for balances in model.logs:
        noise = fast_noise(balances, model.cart)
        found += [noise_rollouts(balances, model.cart, noise, generator) for _ in range(DRAWS)]
    return joined(found)


def measured_gap(guess: CartModel, nominal: Model, final: Model) -> Gap:
    """Of the cart as it was believed, refitted and extended. Where nothing moves, all is noise."""
    if not any(len(starts(balances)) for balances in nominal.logs):
        return _at_rest(nominal)
    rolled = {
        "before": cart_rollouts(nominal, guess),
        "refitted": held_out_rollouts(nominal),
        "after": held_out_rollouts(final),
        "noise_floor": floor_rollouts(final),
    }
    gaps = {name: one.gaps() for name, one in rolled.items()}
    by = {name: one.by_coordinate() for name, one in rolled.items()}
    if not np.isfinite([gap[1] for gap in gaps.values()]).all():
        names = ", ".join(balances.name for balances in nominal.logs)
        raise DataError(f"{names}: simulations run away from it; look for numbers that are not in SI units")
    horizons = {
        f"{horizon:g} s": {name: float(gap[i]) for name, gap in gaps.items()}
        for i, horizon in enumerate(HORIZONS)
        if all(np.isfinite(gap[i]) for gap in gaps.values())
    }
    coordinates_ = {c: {name: float(one[1, i]) for name, one in by.items()} for i, c in enumerate(COORDINATES)}
    return Gap(**horizons["1 s"], per_coordinate=coordinates_, per_horizon=horizons)


def _at_rest(model: Model) -> Gap:
    std = np.max([balances.motion.noise.pose for balances in model.logs], axis=0)
    names = ("before", "refitted", "after", "noise_floor")
    alike = dict.fromkeys(names, float(np.hypot(std[0], std[1])))
    by = {c: dict.fromkeys(names, float(s)) for c, s in zip(COORDINATES, std, strict=True)}
    return Gap(**alike, per_coordinate=by, per_horizon={"1 s": alike})


def _without(model: Model, fold: int) -> CartModel:
    """The model's cart as the stretches of other folds teach it; what happens once stays as it is."""
    prior = model.prior
    free = np.flatnonzero(prior.free)
    sums, scale = model.sums, model.score.scale
    kept = sums[:, model.folds.stretches % FOLDS != fold].sum(axis=1)
    joint = np.tensordot(scale**-2.0, kept, (0, 0))
    q = len(model.prior_std)
    loose = np.append(~_fixed(model)[free], np.ones(q - len(free), dtype=bool))
    own = np.flatnonzero(loose)
    off = coordinates(model.cart)[free] - prior.mean[free]
    pull = joint[:q, q].copy()
    pull[: len(free)] -= off / prior.std[free] ** 2
    information = joint[:q, :q] + np.diag(model.prior_std**-2.0)
    step = np.zeros(q)
    step[own] = np.linalg.solve(information[np.ix_(own, own)], pull[own])
    z = coordinates(model.cart)
    z[free] += np.clip(step[: len(free)], -1.0, 1.0)
    cart = with_coordinates(model.cart, z)
    effects = list(cart.effects)
    for i, effect in enumerate(model.cart.constraint_effects):
        at = next(k for k, e in enumerate(effects) if e.key == effect.key)
        effects[at] = effect.scaled(1.0 + float(step[len(free) + i]))
    return replace(cart, effects=tuple(effects))


def _fixed(model: Model) -> np.ndarray:
    """Parameters (p,) of what happens once: held out, it can't be learned."""
    once: list[bool] = [False] * 4
    for effect in model.cart.effects:
        keep = effect.gate in (Gate.WHILE, Gate.FROM) and not isinstance(effect, ConstraintEffect)
        once += [keep] * len(effect.parameters)
    return np.array(once)
